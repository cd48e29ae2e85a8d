// Sweeps of a ball.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "engine/base/dispatch.h"
#include "haptics/cut_front.h"
#include "haptics/cutting/account.h"
#include "haptics/lanes.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

namespace {

/// What the kernels need, plain, so that they vectorise.
struct Capsule {
  float ax, ay, az;  // from base
  float abx, aby, abz;
  float inverse_length2, radius;
  bool continues;
};

struct Block {
  float* distance;
  const Tissue* tissue;
  std::size_t stride_x, stride_y;
  int lo_x, lo_y, lo_z;  // from base
  int size_x, size_y, size_z;
};

/// The part of a sweep's work that is looked at together: groups of eight samples along z, and what their rows have in
/// common.
struct Work {
  static constexpr int kGroups = 1024, kRowBatches = 64, kLongest = 512;  // samples of a row
  F8 u[kRowBatches], v[kRowBatches];   // see raise_block()
  I8 base[kRowBatches];                // of the row's first sample
  F8 z[kLongest];                      // heights of the eight samples from there on, from A
  std::uint32_t groups[kGroups];       // first sample << 16 | row
  int batches = 0, count = 0;
};

/// Raises the samples of some groups: new = max(old, min(radius - distance, kInner)), wherever that is above -kMargin.
/// `narrow`: rows are shorter than a group.
template <bool capsule, bool narrow>
TYPODONT_KERNEL bool raise_groups(const Block& block, const Capsule& c, Work& work, PerTissue* removed) {
  const float abx = c.abx, aby = c.aby, abz = c.abz, inverse_length2 = c.inverse_length2, radius = c.radius;
  const float from = c.continues ? 0.0f : -1e30f;
  float* const distance = block.distance;
  const int size_z = block.size_z, count = work.count;
  const auto* const all_u = reinterpret_cast<const float*>(work.u);
  const auto* const all_v = reinterpret_cast<const float*>(work.v);
  const auto* const base = reinterpret_cast<const std::int32_t*>(work.base);
  F8 moved_taken[Work::kGroups];  // groups in which surface moved, and what they lost
  std::int32_t moved_at[Work::kGroups];
  int moved = 0;
  I8 any_raised = {};
  for (int g = 0; g < count; ++g) {
    const std::uint32_t row = work.groups[g] & 0xffff, start = work.groups[g] >> 16;
    const std::int32_t first = base[row] + static_cast<std::int32_t>(start);
    float* const at = distance + first;
    F8 old;
    if constexpr (!narrow) {
      old = *reinterpret_cast<const F8*>(at);
    } else {
      for (int i = 0; i < 8; ++i) old[i] = i < size_z ? at[i] : 1e9f;
    }
    const F8 z = work.z[start];
    const float u = all_u[row], v = all_v[row];
    F8 dot, d2;
    if constexpr (capsule) {
      dot = (u * abx + v * aby) + z * abz;
      F8 s = dot * inverse_length2;
      s = s < 0.0f ? F8{} : s;
      s = s > 1.0f ? F8{} + 1.0f : s;
      const F8 dx = u - s * abx, dy = v - s * aby, dz = z - s * abz;
      d2 = dx * dx + dy * dy + dz * dz;
    } else {
      dot = v + z * abz;
      const F8 dz = z - abz;
      d2 = u + dz * dz;
    }
    take_root(d2);
    F8 depth = radius - d2;
    depth = depth > Sweep::kInner ? F8{} + Sweep::kInner : depth;
    F8 least, now;
    I8 raised;
    raise_eight(old, depth, (dot > from), least, raised, now);
    if constexpr (!narrow) {
      *reinterpret_cast<F8*>(at) = now;
    } else {
      for (int i = 0; i < size_z; ++i) at[i] = now[i];
    }
    any_raised |= raised;
    // Which groups count is not foreseeable: noted without a branch.
    share_taken(old, now, moved_taken[moved]);
    moved_at[moved] = first;
    moved += any_of(moved_taken[moved] > 0.0f);
  }
  if (removed && moved > 0) {
    Account account{removed};
    for (int m = 0; m < moved; ++m) {
      const Tissue* const labels = block.tissue + moved_at[m];
      if constexpr (!narrow) {
        account.add(moved_taken[m], labels);
      } else {
        for (int i = 0; i < size_z; ++i) account.add(static_cast<double>(moved_taken[m][i]), labels[i]);
      }
    }
    account.close();
  }
  work.batches = work.count = 0;
  return any_of(any_raised);
}

/// Appends the lanes of a mask.
TYPODONT_KERNEL void append(const I8& entries, const I8& mask, Work& work) {
  const unsigned which = bits_of(mask);
  I8 first;
  gather_lanes(entries, kCompaction.order[which], first);
  *reinterpret_cast<I8*>(work.groups + work.count) = first;
  work.count += __builtin_popcount(which);
}

/// Raises a block of samples to their depth in a capsule; `capsule` false: the sweep is so short that the ball at B,
/// ahead of A, is all of it. Looks only at samples that can change: in the ball around the sweep; ahead of A and outside
/// the empty ball there, when it continues another. Returns whether anything changed; volume taken is added to `removed`.
template <bool capsule, bool narrow>
TYPODONT_KERNEL bool raise_block(const Block& block, const Capsule& c, PerTissue* removed) {
  const float outer = c.radius + Sweep::kMargin;
  const float length = std::sqrt(c.abx * c.abx + c.aby * c.aby + c.abz * c.abz);
  // The ball that holds all that changes: around B when it is all, else around the middle.
  const float share = capsule ? 0.5f : 1.0f, reach = outer + (capsule ? 0.5f * length : 0.0f) + 1e-3f;
  const float mx = share * c.abx, my = share * c.aby, mz = share * c.abz, reach2 = reach * reach;
  // Inside this ball around A all is empty already when the sweep continues another.
  const float inner = c.radius - Sweep::kInner - 0.01f, inner2 = c.continues && inner > 0 ? inner * inner : -1.0f;
  const float first = c.az - static_cast<float>(block.lo_z);  // A along the rows
  const float end = static_cast<float>(block.size_z);
  const bool rises = c.continues && c.abz > 1e-9f, falls = c.continues && c.abz < -1e-9f;
  const float slope = rises || falls ? 1 / c.abz : 0.0f;
  const float slip = 1e-3f + 1e-6f * outer * length * std::abs(slope);  // rounding of the plane ahead of A
  const int last_start = narrow ? 0 : block.size_z - 8;
  const auto stride_y = static_cast<std::int32_t>(block.stride_y);
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7};
  const I8 counts = {0, 1, 2, 3, 4, 5, 6, 7};
  bool changed = false;
  Work work;
  for (int start = 0; start <= last_start; ++start) {  // the same rounding wherever rows start
    work.z[start] = static_cast<float>(block.lo_z + start) + steps - c.az;
  }
  for (int x = 0; x < block.size_x; ++x) {
    const float px = static_cast<float>(block.lo_x + x) - c.ax;
    if (!(reach2 > (px - mx) * (px - mx))) continue;
    const auto base_x = static_cast<std::int32_t>(static_cast<std::size_t>(x) * block.stride_x);
    for (int y0 = 0; y0 < block.size_y; y0 += 8) {
      // Of eight rows: what can change, as an interval [low, high), and the hole in it.
      const I8 y = y0 + counts;
      const F8 py = static_cast<float>(block.lo_y + y0) + steps - c.ay, qy = py - my;
      F8 half = reach2 - (px - mx) * (px - mx) - qy * qy;
      I8 met = (half > 0.0f) & (y < block.size_y);
      half = met ? half : F8{};
      take_root(half);
      const F8 dot_xy = px * c.abx + py * c.aby;
      F8 low = first + (mz + 1.0f) - half, high = first + (mz + 1.0f) + half;  // truncated later: up, as all is positive
      if (rises) {
        const F8 edge = first + (1.0f - slip) - dot_xy * slope;
        low = edge > low ? edge : low;
      } else if (falls) {
        const F8 edge = first + (1.0f + slip) - dot_xy * slope;
        high = edge < high ? edge : high;
      }
      low = low > 0.0f ? low : F8{};
      high = high < end ? high : F8{} + end;
      met &= low < high;
      if (!any_of(met)) continue;
      low = met ? low : F8{};
      high = met ? high : F8{};
      F8 hole = inner2 - px * px - py * py;
      hole = hole > 0.0f ? hole : F8{};
      take_root(hole);
      F8 hole_from = first + 1.0f - hole, hole_to = first + 1.0f + hole;
      const I8 leave = hole_to - hole_from > 8.0f;  // only worth leaving out when a whole group fits
      hole_from = hole_from > 0.0f ? hole_from : F8{};
      hole_to = hole_to > low ? hole_to : low;
      hole_from = leave & (hole_from < high) ? hole_from : high;
      hole_to = leave ? hole_to : high;
      const I8 a_from = __builtin_convertvector(low, I8), a_to = __builtin_convertvector(hole_from, I8);
      const I8 b_from = __builtin_convertvector(hole_to, I8), b_to = __builtin_convertvector(high, I8);
      // Most rows are one stretch of at most sixteen: two groups without a branch.
      const I8 stretch_a = a_to > a_from, stretch_b = b_to > b_from;
      const I8 from = stretch_a ? a_from : b_from, to = stretch_a ? a_to : b_to;
      const I8 second = from + 8, at0 = from < last_start ? from : I8{} + last_start;
      const I8 at1 = second < last_start ? second : I8{} + last_start;
      const I8 rows = 8 * work.batches + counts;
      work.base[work.batches] = base_x + y * stride_y;
      work.u[work.batches] = capsule ? F8{} + px : (px - mx) * (px - mx) + qy * qy;
      work.v[work.batches] = capsule ? py : dot_xy;
      ++work.batches;
      append(rows | at0 << 16, stretch_a | stretch_b, work);
      append(rows | at1 << 16, second < to, work);
      const I8 rest = (second + 8 < to) | (stretch_a & stretch_b);
      if (any_of(rest)) {
        for (int row = 0; row < 8; ++row) {
          if (!rest[row]) continue;
          for (int start = second[row] + 8; start < to[row]; start += 8) {
            work.groups[work.count++] = static_cast<std::uint32_t>(rows[row] | std::min(start, last_start) << 16);
          }
          if (!stretch_a[row]) continue;
          for (int start = b_from[row]; start < b_to[row]; start += 8) {
            work.groups[work.count++] = static_cast<std::uint32_t>(rows[row] | std::min(start, last_start) << 16);
          }
        }
      }
      // Room for eight more rows of the longest kind.
      if (work.batches == Work::kRowBatches || work.count > Work::kGroups - 8 * (Work::kLongest / 8 + 1) - 8) {
        changed |= raise_groups<capsule, narrow>(block, c, work, removed);
      }
    }
  }
  changed |= raise_groups<capsule, narrow>(block, c, work, removed);
  return changed;
}

// Compiled twice and chosen at run time. Every sample is computed by itself and FMA is off for the whole program, so
// that every processor, and every way of cutting the work into rows, gives the same bits.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool raise_capsule(const Block* block, const Capsule* capsule, PerTissue* removed) {
  return block->size_z < 8 ? raise_block<true, true>(*block, *capsule, removed)
                           : raise_block<true, false>(*block, *capsule, removed);
}
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool raise_ball_ahead(const Block* block, const Capsule* capsule, PerTissue* removed) {
  return block->size_z < 8 ? raise_block<false, true>(*block, *capsule, removed)
                           : raise_block<false, false>(*block, *capsule, removed);
}

/// A cut before which stands a front (CutFront), plain. Positions count from the first voxel of the front's first block.
struct BallFront {
  Capsule c;
  glm::ivec3 origin;  // of those positions, from the base of c
  float* distance;    // at the origin
  const Tissue* tissue;
  int stride_x, stride_y;
  glm::ivec3 lo, hi;             // what the sweep may reach, and a voxel more
  glm::ivec3 held_lo, held_hi;   // what the patch holds
  float* heights;  // of eight samples along z, 16 floats for each first one: see fill_heights()
  int heights_end;
  float* due;      // of the block at the origin
  int due_x, due_y;
  float way;       // of the head, by the end of this sweep
  float ahead;     // … and how much farther the groups that are listed serve; 0: none are listed
  float slip;      // how far a depth may be off by rounding
  float* x;        // groups
  float* y;
  std::int32_t* z;  // of their heights
  std::int32_t* at;
  int room, count;  // count > room: more than there is room for
};

/// Heights from A of the eight samples from each first one on. Of a ball just their squares, from B, and how far they lie
/// ahead.
template <bool capsule>
TYPODONT_KERNEL void fill_heights(const BallFront& f) {
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7};
  // Groups reach beyond the sweep to the ends of their blocks, and were listed when the head was up to a voxel away.
  for (int z = std::max((f.lo.z & ~7) - 8, 0); z <= std::min((f.hi.z | 7) + 8, f.heights_end - 1); ++z) {
    const F8 height = static_cast<float>(f.origin.z + z) + steps - f.c.az, dz = height - f.c.abz;
    F8* const to = reinterpret_cast<F8*>(f.heights + 16 * z);
    to[0] = capsule ? height : dz * dz;
    to[1] = height * f.c.abz;
  }
}

/// Depth of eight samples of a row and what of it counts; rows as in raise_block().
template <bool capsule>
TYPODONT_KERNEL void depth_of_eight(const Capsule& c, float from, const F8& u, const F8& v, const float* heights, F8& depth,
                                    I8& ahead) {
  const F8 first = reinterpret_cast<const F8*>(heights)[0], second = reinterpret_cast<const F8*>(heights)[1];
  F8 d2;
  if constexpr (capsule) {
    const F8 dot = (u * c.abx + v * c.aby) + second;
    F8 s = dot * c.inverse_length2;
    s = s < 0.0f ? F8{} : s;
    s = s > 1.0f ? F8{} + 1.0f : s;
    const F8 dx = u - s * c.abx, dy = v - s * c.aby, dz = first - s * c.abz;
    d2 = dx * dx + dy * dy + dz * dz;
    ahead = dot > from;
  } else {
    d2 = u + first;
    ahead = v + second > from;
  }
  take_root(d2);
  depth = c.radius - d2;
  depth = depth > Sweep::kInner ? F8{} + Sweep::kInner : depth;
}

/// Eight rows: what their samples have in common.
template <bool capsule>
TYPODONT_KERNEL void row_terms(const BallFront& f, const F8& x, const F8& y, F8& u, F8& v) {
  const Capsule& c = f.c;
  const F8 px = x + static_cast<float>(f.origin.x) - c.ax, py = y + static_cast<float>(f.origin.y) - c.ay;
  if constexpr (capsule) {
    u = px, v = py;
  } else {
    const F8 qx = px - c.abx, qy = py - c.aby;
    u = qx * qx + qy * qy, v = px * c.abx + py * c.aby;
  }
}

/// Raises the groups that are listed.
template <bool capsule>
TYPODONT_KERNEL bool raise_listed(const BallFront& f, PerTissue* removed) {
  constexpr int kChunk = 256, kAhead = 24;  // groups, fetched in time
  const Capsule c = f.c;
  const float from = c.continues ? 0.0f : -1e30f;
  fill_heights<capsule>(f);
  float* const distance = f.distance;
  const float* const heights = f.heights;
  const std::int32_t* const group_z = f.z;
  const std::int32_t* const group_at = f.at;
  const int count = f.count;
  F8 moved_taken[kChunk];
  std::int32_t moved_at[kChunk];
  F8 u[kChunk / 8], v[kChunk / 8];
  I8 any_raised = {};
  Account account{removed};
  for (int g0 = 0; g0 < count; g0 += kChunk) {
    const int end = std::min(count - g0, kChunk);
    for (int g = 0; g < end; g += 8) {
      row_terms<capsule>(f, *reinterpret_cast<const F8*>(f.x + g0 + g), *reinterpret_cast<const F8*>(f.y + g0 + g), u[g / 8],
                         v[g / 8]);
    }
    const float* const u_of = reinterpret_cast<const float*>(u);
    const float* const v_of = reinterpret_cast<const float*>(v);
    std::size_t moved = 0;
    for (int g = 0; g < end; ++g) {
      const std::int32_t first = group_at[g0 + g];
      __builtin_prefetch(distance + group_at[g0 + g + kAhead]);
      float* const at = distance + first;
      const F8 old = *reinterpret_cast<const F8*>(at);
      F8 depth;
      I8 ahead;
      depth_of_eight<capsule>(c, from, F8{} + u_of[g], F8{} + v_of[g], heights + group_z[g0 + g], depth, ahead);
      F8 least, now;
      I8 raised;
      raise_eight(old, depth, ahead, least, raised, now);
      *reinterpret_cast<F8*>(at) = now;
      any_raised |= raised;
      // Which groups count is not foreseeable: noted without a branch.
      F8 taken;
      share_taken(old, now, taken);
      moved_taken[moved] = taken;
      moved_at[moved] = first;
      moved += any_of(taken > 0.0f);
    }
    for (std::size_t m = 0; m < moved; ++m) {
      account.add(moved_taken[m], f.tissue + moved_at[m]);
    }
  }
  account.close();
  return any_of(any_raised);
}

/// Raises all blocks that are due, finds when they will be due again, and lists what may change until the head has come
/// `ahead`.
template <bool capsule>
TYPODONT_KERNEL bool raise_due(BallFront& f, PerTissue* removed) {
  constexpr int kRows = 4, kDeep = 8, kStretch = 64;  // samples of a row that are listed together
  constexpr float kHalf = 4.1f, kNever = 1e9f;        // from a block's centre to its corners
  const Capsule c = f.c;
  const float from = c.continues ? 0.0f : -1e30f;
  const float length = std::sqrt(c.abx * c.abx + c.aby * c.aby + c.abz * c.abz);
  const float outer = c.radius + Sweep::kMargin, enough = f.way + f.ahead;
  fill_heights<capsule>(f);
  const F8 row_x[2] = {{0, 0, 0, 0, 1, 1, 1, 1}, {2, 2, 2, 2, 3, 3, 3, 3}}, row_y = {0, 1, 2, 3, 0, 1, 2, 3};
  I8 any_raised = {};
  Account account{removed};
  f.count = 0;
  for (int x0 = f.lo.x & ~(kRows - 1); x0 <= f.hi.x; x0 += kRows) {
    for (int y0 = f.lo.y & ~(kRows - 1); y0 <= f.hi.y; y0 += kRows) {
      float* const due = f.due + (x0 / kRows) * f.due_x + (y0 / kRows) * f.due_y;
      const float bx = static_cast<float>(f.origin.x + x0) + 1.5f - c.ax - c.abx;
      const float by = static_cast<float>(f.origin.y + y0) + 1.5f - c.ay - c.aby;
      float u[16], v[16];
      bool rows_known = false;
      for (int stretch = f.lo.z & ~(kDeep - 1); stretch <= f.hi.z; stretch += kStretch) {
        std::uint64_t live[16] = {};
        bool listed = false;
        const int end = std::min(f.hi.z, stretch + kStretch - 1);
        for (int z0 = stretch; z0 <= end; z0 += kDeep) {
          float& block_due = due[z0 / kDeep];
          if (block_due >= enough) continue;
          const float bz = static_cast<float>(f.origin.z + z0) + 3.5f - c.az - c.abz;
          const float away = std::sqrt(bx * bx + by * by + bz * bz) - (kHalf + outer + f.slip);
          if (away - length >= f.ahead) {
            block_due = f.way + away;
            continue;
          }
          const bool whole = x0 >= f.held_lo.x && y0 >= f.held_lo.y && z0 >= f.held_lo.z && x0 + kRows - 1 <= f.held_hi.x &&
                             y0 + kRows - 1 <= f.held_hi.y && z0 + kDeep - 1 <= f.held_hi.z;
          // Far out in the air: field and depth change by at most one per voxel each.
          if (whole) {
            const float middle = f.distance[(x0 + 1) * f.stride_x + (y0 + 1) * f.stride_y + z0 + 3];
            const float least = middle - kHalf - f.slip, slack = least - (length - Sweep::kMargin - away);
            if (least >= Sweep::kInner || slack >= f.ahead) {
              block_due = least >= Sweep::kInner ? kNever : f.way + slack;
              continue;
            }
          }
          if (!rows_known) {
            rows_known = true;
            for (int half = 0; half < 2; ++half) {
              F8 u8, v8;
              row_terms<capsule>(f, row_x[half] + static_cast<float>(x0), row_y + static_cast<float>(y0), u8, v8);
              std::memcpy(u + 8 * half, &u8, sizeof u8);
              std::memcpy(v + 8 * half, &v8, sizeof v8);
            }
          }
          const float* const heights = f.heights + 16 * z0;
          F8 least_slack = F8{} + kNever;
          for (int row = 0; row < 16; ++row) {
            const int x = x0 + (row >> 2), y = y0 + (row & 3);
            if (!whole && (x < f.lo.x || x > f.hi.x || y < f.lo.y || y > f.hi.y)) continue;
            const int first = x * f.stride_x + y * f.stride_y + z0;
            float* const at = f.distance + first;
            const F8 old = *reinterpret_cast<const F8*>(at);
            F8 depth;
            I8 ahead;
            depth_of_eight<capsule>(c, from, F8{} + u[row], F8{} + v[row], heights, depth, ahead);
            F8 least, now;
            I8 raised;
            raise_eight(old, depth, ahead, least, raised, now);
            *reinterpret_cast<F8*>(at) = now;
            any_raised |= raised;
            F8 taken;
            share_taken(old, now, taken);
            if (any_of(taken > 0.0f)) account.add(taken, f.tissue + first);
            // Where the head has come to its deepest nothing changes any more.
            F8 slack = (raised ? now : least) - depth;
            slack = now >= Sweep::kInner ? F8{} + kNever : slack;
            least_slack = slack < least_slack ? slack : least_slack;
            live[row] |= static_cast<std::uint64_t>(bits_of(slack < f.ahead + f.slip)) << (z0 - stretch);
          }
          float slack = least_slack[0];
          for (int i = 1; i < 8; ++i) slack = std::min(slack, least_slack[i]);
          block_due = whole ? f.way + (slack - f.slip) : f.way;
          listed = true;
        }
        if (!listed || !(f.ahead > 0)) continue;
        for (int row = 0; row < 16; ++row) {
          for (std::uint64_t rest = live[row]; rest != 0;) {
            const int z = std::countr_zero(rest);
            rest &= z + 8 < kStretch ? ~std::uint64_t{0} << (z + 8) : 0;
            const int i = std::min(f.count++, f.room), x = x0 + (row >> 2), y = y0 + (row & 3);
            f.x[i] = static_cast<float>(x), f.y[i] = static_cast<float>(y), f.z[i] = 16 * (stretch + z);
            f.at[i] = x * f.stride_x + y * f.stride_y + stretch + z;
          }
        }
      }
    }
  }
  account.close();
  return any_of(any_raised);
}

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool raise_due_capsule(BallFront* front, PerTissue* removed) { return raise_due<true>(*front, removed); }
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool raise_due_ball(BallFront* front, PerTissue* removed) { return raise_due<false>(*front, removed); }
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool raise_listed_capsule(BallFront* front, PerTissue* removed) { return raise_listed<true>(*front, removed); }
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool raise_listed_ball(BallFront* front, PerTissue* removed) { return raise_listed<false>(*front, removed); }

}  // namespace

bool Sweep::raise_ball(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                       std::size_t stride_y, const Tissue* tissue, PerTissue* removed) const noexcept {
  const Capsule capsule{a_.x, a_.y, a_.z, ab_.x, ab_.y, ab_.z, inverse_length2_, radius_, continues_};
  const glm::ivec3 from = lo - base_;
  const bool ball = is_ball();
  bool changed = false;
  for (int z = 0; z < size.z; z += Work::kLongest) {
    const Block block{distance + z, tissue ? tissue + z : nullptr, stride_x, stride_y, from.x, from.y, from.z + z,
                      size.x, size.y, std::min(size.z - z, Work::kLongest)};
    changed |= ball ? raise_ball_ahead(&block, &capsule, removed) : raise_capsule(&block, &capsule, removed);
  }
  return changed;
}

bool Sweep::raise_ball(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
                       PerTissue* removed) const noexcept {
  CutFront::Groups& groups = front.groups_;
  const bool listed = front.way_ <= groups.until && (groups.patch_lo == patch_lo || holds_listed(patch_lo, n));
  if (!listed) groups.origin = front.first_ * glm::ivec3(CutFront::kRows, CutFront::kRows, CutFront::kDeep);
  groups.patch_lo = patch_lo;
  const glm::ivec3 origin = groups.origin, held = patch_lo - origin;
  const std::ptrdiff_t at = -((static_cast<std::ptrdiff_t>(held.x) * n + held.y) * n + held.z);
  // What is listed serves longer when the head is slow; a fast one outruns any list.
  const double ahead = travel_ > CutFront::kMostListed ? 0 : CutFront::kListed;
  BallFront f{{a_.x, a_.y, a_.z, ab_.x, ab_.y, ab_.z, inverse_length2_, radius_, continues_},
              origin - base_,
              distance + at,
              tissue + at,
              n * n,
              n,
              lo_ - 1 - origin,
              hi_ + 1 - origin,
              held,
              held + n - 1,
              front.heights_.data(),
              front.size_.z * CutFront::kDeep,
              front.due_.data(),
              front.size_.y * front.size_.z,
              front.size_.z,
              static_cast<float>(front.way_),
              static_cast<float>(ahead),
              1e-3f + 2e-6f * (radius_ + kMargin),
              groups.x.data(),
              groups.y.data(),
              groups.z.data(),
              groups.at.data(),
              groups.room(),
              groups.count};
  if (listed) return is_ball() ? raise_listed_ball(&f, removed) : raise_listed_capsule(&f, removed);
  const bool changed = is_ball() ? raise_due_ball(&f, removed) : raise_due_capsule(&f, removed);
  groups.until = -1;
  if (ahead > 0 && f.count <= f.room) {
    groups.until = front.way_ + ahead;
    groups.count = f.count;
    for (int i = f.count; i % 8 != 0; ++i) {  // looked at eight by eight
      groups.x[static_cast<std::size_t>(i)] = groups.x[static_cast<std::size_t>(f.count - 1)];
      groups.y[static_cast<std::size_t>(i)] = groups.y[static_cast<std::size_t>(f.count - 1)];
      groups.z[static_cast<std::size_t>(i)] = groups.z[static_cast<std::size_t>(f.count - 1)];
      groups.at[static_cast<std::size_t>(i)] = groups.at[static_cast<std::size_t>(f.count - 1)];
    }
  }
  return changed;
}

}  // namespace typodont::haptics
