#include "haptics/sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/lanes.h"

namespace typodont::haptics {

Sweep::Sweep(const Tool& tool, const Pose& X_WA, const Pose& X_WB, const VoxelFrame& frame, bool continues)
    : sphere_(tool.shape == HeadShape::kSphere), continues_(continues) {
  if (!sphere_) head_ = HeadField(tool, frame.voxel);
  const dvec3 a = frame.to_voxels(X_WA.p), b = frame.to_voxels(X_WB.p);
  base_ = glm::ivec3(glm::floor(a));
  a_ = glm::vec3(a - dvec3(base_));
  ab_ = glm::vec3(b - a);
  const float length2 = glm::dot(ab_, ab_);
  inverse_length2_ = length2 > 1e-12f ? 1 / length2 : 0;
  radius_ = static_cast<float>(tool.radius() / frame.voxel);
  X_VA_ = {a, X_WA.R};
  X_VB_ = {b, X_WB.R};

  // Two poses s apart leave a scallop of s²/8r on a flank of radius r; turning moves the far end by angle × reach.
  const double reach = tool.reach() / frame.voxel;
  const double turn = 2 * std::acos(std::min(1.0, std::abs(glm::dot(X_WA.R, X_WB.R))));
  travel_ = glm::length(b - a) + turn * reach;
  const double step = std::sqrt(8 * std::max(1.0, static_cast<double>(radius_)) * 0.01);
  poses_ = std::clamp(static_cast<int>(std::ceil(travel_ / step)), 1, 512);

  // A slender head fills little of the ball around it: the box of its cylinder, at both ends of a short way.
  const auto extent = [&](const Pose& X) {
    if (sphere_ || poses_ > 1) return dvec3(reach + kMargin);
    const dvec3 axis = X.R * dvec3(0, 0, 1);
    const dvec3 across = glm::sqrt(glm::max(dvec3(1) - axis * axis, dvec3(0)));
    return (tool.length / 2 * glm::abs(axis) + tool.radius() * across) / frame.voxel + (kMargin + 1e-6);
  };
  const dvec3 extent_a = extent(X_WA), extent_b = extent(X_WB);
  lo_ = glm::ivec3(glm::ceil(glm::min(a - extent_a, b - extent_b)));
  hi_ = glm::ivec3(glm::floor(glm::max(a + extent_a, b + extent_b)));
}

Pose Sweep::pose(int k) const noexcept {
  return interpolate(X_VA_, X_VB_, static_cast<double>(k) / poses_);
}

namespace {

/// Share of a voxel inside a surface that passes `distance` voxels from its centre.
inline float share_inside(float distance) {
  return std::clamp(0.5f - distance, 0.0f, 1.0f);
}

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

/// Shares of the voxels inside the surface at some distances.
TYPODONT_KERNEL void shares_inside(const F8& distance, F8& share) {
  share = 0.5f - distance;
  share = share < 0.0f ? F8{} : share;
  share = share > 1.0f ? F8{} + 1.0f : share;
}

/// Volume taken, by label: a running sum as long as the label stays the same.
struct Account {
  PerTissue* removed;
  D4 low = {}, high = {};
  std::uint64_t label = 0;  // eight times

  /// Of eight samples: shares before less after.
  TYPODONT_KERNEL void add(const F8& was, const F8& is, const Tissue* labels) {
    F8 taken, after;
    shares_inside(was, taken);
    shares_inside(is, after);
    taken -= after;
    std::uint64_t eight;
    std::memcpy(&eight, labels, sizeof eight);
    if (eight != label) {
      if (eight != (eight & 0xff) * 0x0101010101010101u) {
        for (int i = 0; i < 8; ++i) add(static_cast<double>(taken[i]), labels[i]);
        return;
      }
      close();
      label = eight;
    }
    low += __builtin_convertvector(__builtin_shufflevector(taken, taken, 0, 1, 2, 3), D4);
    high += __builtin_convertvector(__builtin_shufflevector(taken, taken, 4, 5, 6, 7), D4);
  }
  TYPODONT_KERNEL void add(double taken, Tissue tissue) { (*removed)[static_cast<std::size_t>(tissue)] += taken; }
  TYPODONT_KERNEL void close() {
    const D4 sum = low + high;
    (*removed)[label & 0xff] += (sum[0] + sum[1]) + (sum[2] + sum[3]);
    low = high = D4{};
  }
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
  F8 moved_old[Work::kGroups];  // groups in which surface moved: what they held before
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
    const F8 least = old > -Sweep::kMargin ? old : F8{} - Sweep::kMargin;
    const I8 raised = (dot > from) & (depth > least);
    const F8 now = raised ? depth : old;
    if constexpr (!narrow) {
      *reinterpret_cast<F8*>(at) = now;
    } else {
      for (int i = 0; i < size_z; ++i) at[i] = now[i];
    }
    any_raised |= raised;
    // Which groups count is not foreseeable: noted without a branch.
    moved_old[moved] = old;
    moved_at[moved] = first;
    moved += any_of(raised & (now > -0.5f) & (old < 0.5f));
  }
  if (removed && moved > 0) {
    Account account{removed};
    for (int m = 0; m < moved; ++m) {
      const float* const at = distance + moved_at[m];
      const Tissue* const labels = block.tissue + moved_at[m];
      if constexpr (!narrow) {
        account.add(moved_old[m], *reinterpret_cast<const F8*>(at), labels);
      } else {
        for (int i = 0; i < size_z; ++i) {
          account.add(static_cast<double>(share_inside(moved_old[m][i]) - share_inside(at[i])), labels[i]);
        }
      }
    }
    account.close();
  }
  work.batches = work.count = 0;
  return any_of(any_raised);
}

/// For each set of lanes: these lanes first.
struct Compaction {
  I8 order[256] = {};
  Compaction() {
    for (int mask = 0; mask < 256; ++mask) {
      for (int lane = 0, next = 0; lane < 8; ++lane) {
        if (mask >> lane & 1) order[mask][next++] = lane;
      }
    }
  }
};
const Compaction kCompaction;

/// Appends the lanes of a mask.
TYPODONT_KERNEL void append(const I8& entries, const I8& mask, Work& work) {
  const unsigned which = bits_of(mask);
  const I8& order = kCompaction.order[which];
  I8 first;
#ifdef __clang__  // has no shuffle by a variable
  for (int i = 0; i < 8; ++i) first[i] = entries[order[i]];
#else
  first = __builtin_shuffle(entries, order);
#endif
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
TYPODONT_DISPATCH("avx2", "default")
bool raise_capsule(const Block* block, const Capsule* capsule, PerTissue* removed) {
  return block->size_z < 8 ? raise_block<true, true>(*block, *capsule, removed)
                           : raise_block<true, false>(*block, *capsule, removed);
}
TYPODONT_DISPATCH("avx2", "default")
bool raise_ball_ahead(const Block* block, const Capsule* capsule, PerTissue* removed) {
  return block->size_z < 8 ? raise_block<false, true>(*block, *capsule, removed)
                           : raise_block<false, false>(*block, *capsule, removed);
}

constexpr int kRows = 4, kDeep = 8;  // a block of a general head's sweep: kRows × kRows rows of kDeep samples
constexpr float kHalf = 4.1f;         // from its centre to a corner, |(1.5, 1.5, 3.5)|, and a little more
constexpr float kOneSided = 1e-5f;    // share of its way by which a head may advance and yet count as receding

/// A piece of the meridian in floats: HeadField::Piece with its outward normals at either end.
struct FlatPiece {
  float ax, az, bx, bz, dx, dz, inverse2, cx, cz, radius;
  float nax, naz, nbx, nbz;
};

/// Eight blocks seen from a head: how far their centres are from it and from its pieces, and the way out.
struct Seen {
  F8 distance, to_piece[HeadField::kMaxPieces];
  F8 x, y, z, rho, n_rho, n_z;  // centre and direction in T
};

/// `R`: from V to T, by columns; centres from the head's.
TYPODONT_DISPATCH("avx2", "default")
void see_blocks(const FlatPiece* pieces, int count, const float* R, const F8* center, Seen* seen) {
  const F8 vx = center[0], vy = center[1], vz = center[2];
  const F8 x = R[0] * vx + R[3] * vy + R[6] * vz, y = R[1] * vx + R[4] * vy + R[7] * vz,
           z = R[2] * vx + R[5] * vy + R[8] * vz;
  F8 rho = x * x + y * y;
  take_root(rho);
  F8 best = F8{} + 1e30f, n_rho = {}, n_z = {};
  I8 outside = {};
  for (int p = 0; p < count; ++p) {
    const FlatPiece& piece = pieces[p];
    const F8 ex = rho - piece.ax, ez = z - piece.az;
    const I8 beyond = piece.dx * ez - piece.dz * ex < 0.0f;
    F8 d, fx, fz;
    if (piece.radius == 0.0f) {
      F8 s = (ex * piece.dx + ez * piece.dz) * piece.inverse2;
      s = s < 0.0f ? F8{} : s;
      s = s > 1.0f ? F8{} + 1.0f : s;
      fx = ex - s * piece.dx, fz = ez - s * piece.dz;
      outside |= beyond;
    } else {
      const F8 gx = rho - piece.bx, gz = z - piece.bz, wx = rho - piece.cx, wz = z - piece.cz;
      F8 length = wx * wx + wz * wz;
      length = length > 1e-12f ? length : F8{} + 1e-12f;
      take_root(length);
      const float ux = piece.ax - piece.cx, uz = piece.az - piece.cz, tx = piece.bx - piece.cx, tz = piece.bz - piece.cz;
      const I8 between = (ux * wz - uz * wx >= 0.0f) & (wx * tz - wz * tx >= 0.0f);
      const I8 first = ex * ex + ez * ez < gx * gx + gz * gz;
      const F8 off = (length - piece.radius) / length;
      fx = between ? off * wx : first ? ex : gx;
      fz = between ? off * wz : first ? ez : gz;
      outside |= beyond & (length > piece.radius);
    }
    d = fx * fx + fz * fz;
    take_root(d);
    seen->to_piece[p] = d;
    const I8 nearer = d < best;
    best = nearer ? d : best;
    n_rho = nearer ? fx : n_rho;
    n_z = nearer ? fz : n_z;
  }
  const F8 signed_best = outside ? best : -best;
  // Where the centre lies on the surface the direction is of no use, nor needed: see bound below.
  const F8 inverse = best > 1e-3f ? 1.0f / signed_best : F8{};
  seen->distance = signed_best;
  seen->n_rho = n_rho * inverse;
  seen->n_z = n_z * inverse;
  seen->x = x, seen->y = y, seen->z = z, seen->rho = rho;
}

/// A block and the head beside it.
struct HeadBlock {
  float* distance;
  const Tissue* tissue;
  std::ptrdiff_t at, stride_x, stride_y;  // of its first sample, inside the array or not
  int from[3], to[3];                     // the part of it that is meant
  float px, py, pz;                       // its first sample in T
  float ex[3], ey[3], ez[3];              // to the next sample along x, y, z, in T
  // No sample is deeper than this plane says: the distance from a convex head is convex.
  float bound, bound_x, bound_y, bound_z;
  const FlatPiece* pieces;
  int which[HeadField::kMaxPieces], count;  // those that can be the closest one to any of the samples
  bool smooth;                              // there is only one, and between its ends
};

/// Depth of eight samples of the meridian's half plane, or of points in T.
TYPODONT_KERNEL void depth_in_head(const HeadBlock& block, const F8& rho, const F8& z, F8& depth) {
  const FlatPiece& only = block.pieces[block.which[0]];
  if (block.smooth && only.radius == 0.0f) {
    depth = (only.ax - rho) * only.nax + (only.az - z) * only.naz;
    return;
  }
  if (block.smooth) {
    const F8 vx = rho - only.cx, vz = z - only.cz;
    depth = vx * vx + vz * vz;
    take_root(depth);
    depth = only.radius - depth;
    return;
  }
  F8 best = F8{} + 1e30f;
  I8 outside = {};
  for (int p = 0; p < block.count; ++p) {
    const FlatPiece& piece = block.pieces[block.which[p]];
    const float ax = piece.ax, az = piece.az, dx = piece.dx, dz = piece.dz, radius = piece.radius;
    const F8 ex = rho - ax, ez = z - az;
    const I8 beyond = dx * ez - dz * ex < 0.0f;
    if (radius == 0.0f) {
      F8 s = (ex * dx + ez * dz) * piece.inverse2;
      s = s < 0.0f ? F8{} : s;
      s = s > 1.0f ? F8{} + 1.0f : s;
      const F8 fx = ex - s * dx, fz = ez - s * dz, d2 = fx * fx + fz * fz;
      best = d2 < best ? d2 : best;
      outside |= beyond;
    } else {
      const float bx = piece.bx, bz = piece.bz, cx = piece.cx, cz = piece.cz;
      const float ux = ax - cx, uz = az - cz, wx = bx - cx, wz = bz - cz;
      const F8 gx = rho - bx, gz = z - bz, vx = rho - cx, vz = z - cz;
      F8 length = vx * vx + vz * vz;
      take_root(length);
      const F8 on = (length - radius) * (length - radius);
      const F8 e2 = ex * ex + ez * ez, g2 = gx * gx + gz * gz, ends = e2 < g2 ? e2 : g2;
      const I8 between = (ux * vz - uz * vx >= 0.0f) & (vx * wz - vz * wx >= 0.0f);
      const F8 d2 = between ? on : ends;
      best = d2 < best ? d2 : best;
      outside |= beyond & (length > radius);
    }
  }
  take_root(best);
  depth = outside ? -best : best;
}

/// new = max(old, min(depth, kInner)), depths below -kMargin not counted. Returns whether anything changed.
TYPODONT_DISPATCH("avx2", "default") bool raise_head_block(const HeadBlock* block_at, PerTissue* removed) {
  const HeadBlock& block = *block_at;
  const int* const from = block.from;
  const int* const to = block.to;
  const bool whole = from[2] == 0 && to[2] == kDeep;
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7};
  const F8 along_x = steps * block.ez[0], along_y = steps * block.ez[1], along_z = steps * block.ez[2];
  const F8 bound = block.bound + steps * block.bound_z;
  bool changed = false;
  Account account{removed};
  for (int ix = from[0]; ix < to[0]; ++ix) {
    for (int iy = from[1]; iy < to[1]; ++iy) {
      const float fx = static_cast<float>(ix), fy = static_cast<float>(iy);
      float* const row = block.distance + (block.at + ix * block.stride_x + iy * block.stride_y);
      F8 old = F8{} + 1e9f;  // what lies outside the part is not raised
      if (whole) {
        old = *reinterpret_cast<const F8*>(row);
      } else {
        for (int i = from[2]; i < to[2]; ++i) old[i] = row[i];
      }
      F8 most = bound + (fx * block.bound_x + fy * block.bound_y);
      most = most > Sweep::kInner ? F8{} + Sweep::kInner : most;
      const F8 least = old > -Sweep::kMargin ? old : F8{} - Sweep::kMargin;
      if (!any_of(most > least)) continue;
      const F8 x = (block.px + fx * block.ex[0] + fy * block.ey[0]) + along_x;
      const F8 y = (block.py + fx * block.ex[1] + fy * block.ey[1]) + along_y;
      const F8 z = (block.pz + fx * block.ex[2] + fy * block.ey[2]) + along_z;
      F8 rho = x * x + y * y, depth;
      take_root(rho);
      depth_in_head(block, rho, z, depth);
      depth = depth > Sweep::kInner ? F8{} + Sweep::kInner : depth;
      const I8 raised = depth > least;
      if (!any_of(raised)) continue;
      changed = true;
      const F8 now = raised ? depth : old;
      if (whole) {
        *reinterpret_cast<F8*>(row) = now;
      } else {
        for (int i = from[2]; i < to[2]; ++i) row[i] = now[i];
      }
      if (!removed || !any_of(raised & (now > -0.5f) & (old < 0.5f))) continue;
      const Tissue* const labels = block.tissue + (row - block.distance);
      if (whole) {
        account.add(old, now, labels);
      } else {
        for (int i = from[2]; i < to[2]; ++i) {
          account.add(static_cast<double>(share_inside(old[i]) - share_inside(now[i])), labels[i]);
        }
      }
    }
  }
  if (removed) account.close();
  return changed;
}

/// How fast, at most, the head comes nearer to any sample around a point of its half plane: the greatest n·w over the
/// normals of some neighbouring pieces, turned about the axis by as much as `kHalf` is seen from it. `w` in T.
float fastest_advance(const FlatPiece& first, const FlatPiece& last, const glm::vec3& center, float rho,
                      const glm::vec3& w) {
  const float across = std::sqrt(w.x * w.x + w.y * w.y);
  float along = across;  // the greatest part of w away from the axis
  if (rho > kHalf) {
    const float ux = center.x / rho, uy = center.y / rho, sine = kHalf / rho, cosine = std::sqrt(1 - sine * sine);
    const float radial = w.x * ux + w.y * uy, round = std::abs(w.x * uy - w.y * ux);
    if (!(radial > 0 && round * cosine <= radial * sine)) along = radial * cosine + round * sine;
  }
  // Normals turn from the first piece's to the last one's; the greatest is at w itself when that lies between.
  if (first.nax * w.z - first.naz * along >= 0 && along * last.nbz - w.z * last.nbx >= 0) {
    return std::sqrt(along * along + w.z * w.z);
  }
  return std::max(first.nax * along + first.naz * w.z, last.nbx * along + last.nbz * w.z);
}

}  // namespace

bool Sweep::raise(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                  std::size_t stride_y, const Tissue* tissue, PerTissue* removed) const noexcept {
  return sphere_ ? raise_ball(lo, size, distance, stride_x, stride_y, tissue, removed)
                 : raise_head(lo, size, distance, stride_x, stride_y, tissue, removed);
}

bool Sweep::raise_ball(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                       std::size_t stride_y, const Tissue* tissue, PerTissue* removed) const noexcept {
  const Capsule capsule{a_.x, a_.y, a_.z, ab_.x, ab_.y, ab_.z, inverse_length2_, radius_, continues_};
  const glm::ivec3 from = lo - base_;
  // Between capsule and balls lies ab²/8r: nothing, for a short step that continues another.
  const float length2 = glm::dot(ab_, ab_);
  const bool ball = continues_ && length2 < 8e-5f * radius_;
  bool changed = false;
  for (int z = 0; z < size.z; z += Work::kLongest) {
    const Block block{distance + z, tissue ? tissue + z : nullptr, stride_x, stride_y, from.x, from.y, from.z + z,
                      size.x, size.y, std::min(size.z - z, Work::kLongest)};
    changed |= ball ? raise_ball_ahead(&block, &capsule, removed) : raise_capsule(&block, &capsule, removed);
  }
  return changed;
}

bool Sweep::raise_head(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                       std::size_t stride_y, const Tissue* tissue, PerTissue* removed) const noexcept {
  bool changed = false;
  FlatPiece pieces[HeadField::kMaxPieces];
  for (int p = 0; p < head_.count; ++p) {
    const HeadField::Piece& piece = head_.pieces[p];
    const double length = std::sqrt(1 / piece.inverse2), r = piece.radius;
    const bool line = r == 0;
    const double values[] = {piece.ax, piece.az, piece.bx, piece.bz, piece.dx, piece.dz, piece.inverse2, piece.cx, piece.cz, r,
                             line ? piece.dz / length : (piece.ax - piece.cx) / r,
                             line ? -piece.dx / length : (piece.az - piece.cz) / r,
                             line ? piece.dz / length : (piece.bx - piece.cx) / r,
                             line ? -piece.dx / length : (piece.bz - piece.cz) / r};
    static_assert(sizeof(FlatPiece) == std::size(values) * sizeof(float));
    float flat[std::size(values)];
    for (std::size_t i = 0; i < std::size(values); ++i) flat[i] = static_cast<float>(values[i]);
    std::memcpy(&pieces[p], flat, sizeof flat);
  }
  // Blocks are aligned to the voxel grid, so that a sample's depth does not depend on how the work was cut up.
  const auto down = [](int v, int step) { return v - (v % step + step) % step; };
  const glm::ivec3 first(down(lo.x, kRows), down(lo.y, kRows), down(lo.z, kDeep)), last = lo + size - 1;
  const glm::vec3 middle((kRows - 1) / 2.0f, (kRows - 1) / 2.0f, (kDeep - 1) / 2.0f);
  for (int k = continues_ ? 1 : 0; k <= poses_; ++k) {
    const Pose X_VT = k == 0 ? X_VA_ : k == poses_ ? X_VB_ : pose(k);
    const glm::dmat3 R_TV = glm::transpose(glm::dmat3(X_VT.R));
    const glm::mat3 R(R_TV);
    const glm::ivec3 base(glm::floor(X_VT.p));
    const glm::vec3 p(X_VT.p - dvec3(base));
    // A point's way in T since the pose before: where the head recedes from all of a block nothing is left to cut.
    const bool after = k > 0;
    const Pose before = k == 1 ? X_VA_ : k > 1 ? pose(k - 1) : X_VT;
    const glm::dmat3 R_TA = glm::transpose(glm::dmat3(before.R));
    const glm::mat3 turned(R_TA - R_TV);
    const glm::vec3 shifted(R_TA * (X_VT.p - before.p));
    float turn = 0;  // of a block's corner about its centre
    for (int c = 0; c < 3; ++c) turn += glm::length(turned[c]) * kHalf;

    glm::ivec3 blocks[8];
    F8 center[3];
    Seen seen;
    int lanes = 0;
    const auto raise_blocks = [&] {
      see_blocks(pieces, head_.count, &R[0].x, center, &seen);
      for (int lane = 0; lane < lanes; ++lane) {
        const float d = seen.distance[lane];
        if (d > kMargin + kHalf) continue;
        // Deep in the head at the pose before too: empty since then.
        if (after && d < -(kInner + kHalf + static_cast<float>(travel_))) continue;
        const glm::ivec3 corner = blocks[lane], inside = corner - lo;
        HeadBlock block;
        block.stride_x = static_cast<std::ptrdiff_t>(stride_x), block.stride_y = static_cast<std::ptrdiff_t>(stride_y);
        block.at = inside.x * block.stride_x + inside.y * block.stride_y + inside.z;
        const int extent[3] = {kRows, kRows, kDeep};
        bool clipped = false;
        for (int i = 0; i < 3; ++i) {
          block.from[i] = std::max(-inside[i], 0);
          block.to[i] = std::min(size[i] - inside[i], extent[i]);
          clipped |= block.to[i] - block.from[i] != extent[i];
        }
        // Far out in the air: field and depth change by at most one per voxel each.
        if (!clipped && distance[block.at + block.stride_x + block.stride_y + 3] + d > 2 * kHalf + 1) continue;
        block.count = 0;
        for (int i = 0; i < head_.count; ++i) {
          if (seen.to_piece[i][lane] < std::abs(d) + 2 * kHalf) block.which[block.count++] = i;
        }
        const glm::vec3 from_head(center[0][lane], center[1][lane], center[2][lane]);
        const glm::vec3 at(seen.x[lane], seen.y[lane], seen.z[lane]);
        const float rho = seen.rho[lane];
        if (after) {
          const glm::vec3 w = turned * from_head + shifted;
          const float fastest = fastest_advance(pieces[block.which[0]], pieces[block.which[block.count - 1]], at, rho, w);
          if (fastest + turn <= kOneSided * glm::length(w)) continue;
        }
        block.distance = distance, block.tissue = tissue;
        const glm::vec3 q = R * (from_head - middle);
        block.px = q.x, block.py = q.y, block.pz = q.z;
        for (int i = 0; i < 3; ++i) block.ex[i] = R[0][i], block.ey[i] = R[1][i], block.ez[i] = R[2][i];
        const float out = rho > 1e-6f ? seen.n_rho[lane] / rho : 0;
        const glm::vec3 n = glm::vec3(out * at.x, out * at.y, seen.n_z[lane]) * R;  // in V
        // Without a direction only the change by one per voxel is known.
        const bool known = glm::dot(n, n) > 0.5f;
        block.bound = known ? glm::dot(n, middle) - d + 1e-3f : kHalf - d;
        block.bound_x = known ? -n.x : 0, block.bound_y = known ? -n.y : 0, block.bound_z = known ? -n.z : 0;
        block.pieces = pieces;
        const FlatPiece& only = pieces[block.which[0]];
        block.smooth = false;
        if (block.count == 1 && only.radius == 0) {
          const float s = ((rho - only.ax) * only.dx + (at.z - only.az) * only.dz) * only.inverse2;
          const float reach = kHalf * std::sqrt(only.inverse2);
          block.smooth = s > reach && s < 1 - reach;
        } else if (block.count == 1) {
          const float vx = rho - only.cx, vz = at.z - only.cz;
          block.smooth = only.nax * vz - only.naz * vx > kHalf && vx * only.nbz - vz * only.nbx > kHalf;
        }
        changed |= raise_head_block(&block, removed);
      }
      lanes = 0;
    };
    for (int x0 = first.x; x0 <= last.x; x0 += kRows) {
      for (int y0 = first.y; y0 <= last.y; y0 += kRows) {
        for (int z0 = first.z; z0 <= last.z; z0 += kDeep) {
          blocks[lanes] = {x0, y0, z0};
          const glm::vec3 c = glm::vec3(blocks[lanes] - base) + middle - p;
          for (int i = 0; i < 3; ++i) center[i][lanes] = c[i];
          if (++lanes == 8) raise_blocks();
        }
      }
    }
    if (lanes > 0) {
      for (int lane = lanes; lane < 8; ++lane) {
        for (int i = 0; i < 3; ++i) center[i][lane] = center[i][0];
      }
      raise_blocks();
    }
  }
  return changed;
}

}  // namespace typodont::haptics
