// Cuts by a spherical head.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/cutting/block.h"
#include "haptics/cutting/lane_ops.h"
#include "haptics/cutting/listed.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

namespace eight {
namespace {
#include "haptics/cutting/cut_kernel.h"
}  // namespace
}  // namespace eight

namespace {

struct Block {
  float* distance;
  const Tissue* tissue;
  std::size_t stride_x, stride_y;
  // lower corner of the box of samples, in voxels from the sweep's base voxel
  int lo_x, lo_y, lo_z;
  int size_x, size_y, size_z;
};

/// Depths of eight samples in the ball, at most kInner (3 voxels). `capsule` true: largest depth during the motion;
/// false: depth at its end. `ahead`: mask of samples ahead of the start A. `u`, `v`: terms of
/// the rows (row_terms()); `first`, `second`: terms of z (fill_heights()).
template <bool capsule>
TYPODONT_INLINE void depth_of_eight(const Capsule& c, float from, const F8& u, const F8& v, const F8& first,
                                    const F8& second, F8& depth, I8& ahead) {
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

/// Cuts with a ball that moves from A to B (a capsule); `capsule` false: only with the ball at B. A continued sweep
/// examines only samples that are ahead of A and outside the ball emptied at A. Returns true if a sample changed.
template <bool capsule, bool narrow>
TYPODONT_INLINE bool carve_block(const Block& block, const Capsule& c, RemovedVolume* removed) {
  const float outer = c.radius + Sweep::kMargin;
  const float length = std::sqrt(c.abx * c.abx + c.aby * c.aby + c.abz * c.abz);
  // Ball around all samples that can change. Its centre is the middle of A and B, or B if `capsule` is false.
  const float fraction = capsule ? 0.5f : 1.0f, reach = outer + (capsule ? 0.5f * length : 0.0f) + 1e-3f;
  const float mx = fraction * c.abx, my = fraction * c.aby, mz = fraction * c.abz, reach2 = reach * reach;
  // If the sweep continues the last one, a ball of radius `inner` around A is empty already.
  const float inner = c.radius - Sweep::kInner - 0.01f, inner2 = c.continues && inner > 0 ? inner * inner : -1.0f;
  // voxels, z of the motion's start A relative to a row's first sample
  const float first = c.az - static_cast<float>(block.lo_z);
  const float end = static_cast<float>(block.size_z);
  const bool rises = c.continues && c.abz > 1e-9f, falls = c.continues && c.abz < -1e-9f;
  const float slope = rises || falls ? 1 / c.abz : 0.0f;
  // rounding error of the test whether a sample is ahead of the motion's start A
  const float slip = 1e-3f + 1e-6f * outer * length * std::abs(slope);
  const int last_start = narrow ? 0 : block.size_z - 8;
  const float from_dot = c.continues ? 0.0f : -1e30f;
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7};
  const I8 counts = {0, 1, 2, 3, 4, 5, 6, 7};
  I8 any_raised = {};
  eight::Taken taken{removed};
  // Raises the samples `from` to `to` - 1 of a row, eight at a time, to max(old, min(radius - distance, kInner)) where
  // radius - distance is above -kMargin (kInner 3, kMargin 3.5 voxels). `u`, `v`: terms of depth_of_eight().
  const auto raise = [&](std::size_t row, float u, float v, int from, int to) __attribute__((always_inline)) {
    for (; from < to; from += 8) {
      const int start = std::min(from, last_start);
      float* const at = block.distance + row + start;
      F8 old;
      if constexpr (!narrow) {
        old = *reinterpret_cast<const F8*>(at);
      } else {
        for (int i = 0; i < 8; ++i) old[i] = i < block.size_z ? at[i] : 1e9f;
      }
      const F8 z = static_cast<float>(block.lo_z + start) + steps - c.az, off = z - c.abz;
      F8 depth, least;
      I8 ahead, raised;
      depth_of_eight<capsule>(c, from_dot, F8{} + u, F8{} + v, capsule ? z : off * off, z * c.abz, depth, ahead);
      const F8 now = eight::raised_to(old, depth, ahead, least, raised);
      if constexpr (!narrow) {
        *reinterpret_cast<F8*>(at) = now;
      } else {
        for (int i = 0; i < block.size_z; ++i) at[i] = now[i];
      }
      any_raised |= raised;
      const I8 lost = eight::share_taken(old, now);
      if (removed && any_of(lost > 0)) taken.add(lost, block.tissue + row + start, at, 0, narrow ? block.size_z : 8);
    }
  };
  for (int x = 0; x < block.size_x; ++x) {
    const float px = static_cast<float>(block.lo_x + x) - c.ax;
    if (!(reach2 > (px - mx) * (px - mx))) continue;
    for (int y0 = 0; y0 < block.size_y; y0 += 8) {
      // Each row's interval [low, high) of samples that can change. hole_from to hole_to: part that is already empty.
      const I8 y = y0 + counts;
      const F8 py = static_cast<float>(block.lo_y + y0) + steps - c.ay, qy = py - my;
      F8 half = reach2 - (px - mx) * (px - mx) - qy * qy;
      I8 met = (half > 0.0f) & (y < block.size_y);
      half = met ? half : F8{};
      take_root(half);
      const F8 dot_xy = px * c.abx + py * c.aby;
      // The values are positive and later truncated, so adding 1 rounds up.
      F8 low = first + (mz + 1.0f) - half, high = first + (mz + 1.0f) + half;
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
      // leaves out the row's empty part only if it is longer than a group
      const I8 leave = hole_to - hole_from > 8.0f;
      hole_from = hole_from > 0.0f ? hole_from : F8{};
      hole_to = hole_to > low ? hole_to : low;
      hole_from = leave & (hole_from < high) ? hole_from : high;
      hole_to = leave ? hole_to : high;
      const I8 a_from = __builtin_convertvector(low, I8), a_to = __builtin_convertvector(hole_from, I8);
      const I8 b_from = __builtin_convertvector(hole_to, I8), b_to = __builtin_convertvector(high, I8);
      const F8 u = capsule ? F8{} + px : (px - mx) * (px - mx) + qy * qy, v = capsule ? py : F8{} + dot_xy;
      for (unsigned rows = bits_of(met); rows != 0; rows &= rows - 1) {
        const int i = std::countr_zero(rows);
        const std::size_t row =
            static_cast<std::size_t>(x) * block.stride_x + static_cast<std::size_t>(y0 + i) * block.stride_y;
        raise(row, u[i], v[i], a_from[i], a_to[i]);
        raise(row, u[i], v[i], b_from[i], b_to[i]);
      }
    }
  }
  if (removed) taken.close();
  return any_of(any_raised);
}

// Compiled for several instruction sets. Samples are independent and FMA is off: the result is bit-identical on every
// processor and for any division into rows.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool carve_block_here(const Block* block, const Capsule* c, bool capsule, RemovedVolume* removed) {
  const bool narrow = block->size_z < 8;
  if (capsule)
    return narrow ? carve_block<true, true>(*block, *c, removed) : carve_block<true, false>(*block, *c, removed);
  return narrow ? carve_block<false, true>(*block, *c, removed) : carve_block<false, false>(*block, *c, removed);
}

/// Safe travel of the samples in 16 rows: distance (voxels) that the head can move before a sample can change.
class SafeTravelRows {
 public:
  static constexpr int kStretch = 64;  // largest number of samples of a row that are listed together

  /// Stores the safe travel of eight samples: how far the head can move before each sample can change.
  TYPODONT_INLINE void put(int row, int z, const F8& safe_travel) {
    std::memcpy(rows_ + row * kRow + z, &safe_travel, sizeof safe_travel);
  }
  /// Smallest safe travel (head motion before a change) among samples z to z + 15 of a row whose bit in `which` is set.
  TYPODONT_INLINE float least(int row, int z, std::uint64_t which) const {
    const I8 bits = I8{} + static_cast<int>(which & 0xffff), one = {1, 2, 4, 8, 16, 32, 64, 128};
    F8 low, high;
    std::memcpy(&low, rows_ + row * kRow + z, sizeof low);
    std::memcpy(&high, rows_ + row * kRow + z + 8, sizeof high);
    low = (bits & one) != 0 ? low : F8{} + kNever;
    high = (bits & (one << 8)) != 0 ? high : F8{} + kNever;
    const F8 both = low < high ? low : high;
    const F4 first = __builtin_shufflevector(both, both, 0, 1, 2, 3),
             second = __builtin_shufflevector(both, both, 4, 5, 6, 7);
    const F4 least = first < second ? first : second;
    return std::min(std::min(least[0], least[1]), std::min(least[2], least[3]));
  }

 private:
  // elements per row; more than kStretch, because a group of 8 or 16 samples may extend beyond kStretch
  static constexpr int kRow = kStretch + 16;
  static constexpr float kNever = 1e9f;

  float rows_[16 * kRow];
};

/// A list of samples is valid while the head moves `ahead` voxels. This path is divided into CutFront::kStages equal
/// stages. Returns the first stage in which a sample with this safe travel can change.
inline int stage_of(float safe_travel, float ahead) {
  const float stage = safe_travel / ahead * CutFront::kStages;
  return stage < 1 ? 0 : std::min(static_cast<int>(stage), CutFront::kStages - 1);
}

/// Input and output of carve_due(): blocks, path length at which each must be examined, list of groups.
struct BallBlocks {
  BallFront f;
  const Tissue* tissue;  // labels, from the first voxel of the stored box (CutFront) on
  int stride_x, stride_y;
  glm::ivec3 lo, hi;            // box of the sweep, plus one voxel on each side
  glm::ivec3 held_lo, held_hi;  // box of the tissue patch
  // for each block: length of the ball's path at which the block must be examined again, voxels
  float* due;
  int due_x, due_y;
  float path_length;  // length of the ball's path at the end of this sweep, voxels
  float ahead;        // voxels; groups of samples that change within this much more path are listed; 0: no list
  float slip;         // voxels, largest rounding error of a depth
  int lanes;          // number of samples in a group
  // Along x, layers of blocks are assigned to the parts 0, 1, …, parts - 1, 0, 1, … `part`: the part that is cut now.
  // `first_layer`: the part to which the first layer belongs.
  int parts, part, first_layer;
  CutFront::Found* found;  // buffer for the list of groups
  // number of groups found; may exceed `capacity`
  int listed, capacity;
};

TYPODONT_DISPATCH("avx2", "default")
void fill_heights(const BallFront* f, bool capsule, int from, int to) {
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7};
  for (int z = from; z < to; z += 8) {
    const F8 height = static_cast<float>(f->origin.z + z) + steps - f->c.az, off = height - f->c.abz;
    *reinterpret_cast<F8*>(f->heights.apart + z) = capsule ? height : off * off;
    *reinterpret_cast<F8*>(f->heights.ahead + z) = height * f->c.abz;
  }
}

/// Computes the terms `u` and `v` of depth_of_eight() for eight rows.
template <bool capsule>
TYPODONT_INLINE void row_terms(const BallFront& f, const F8& x, const F8& y, F8& u, F8& v) {
  const Capsule& c = f.c;
  const F8 px = x + static_cast<float>(f.origin.x) - c.ax, py = y + static_cast<float>(f.origin.y) - c.ay;
  if constexpr (capsule) {
    u = px, v = py;
  } else {
    const F8 qx = px - c.abx, qy = py - c.aby;
    u = qx * qx + qy * qy, v = px * c.abx + py * c.aby;
  }
}

/// Position of a group of samples relative to the ball: 0 ahead, 1 beside, 2 behind. Groups with the same position are
/// processed together.
inline int side_of(const Capsule& c, const glm::ivec3& group, int lanes) {
  const float first = (static_cast<float>(group.x) - c.ax) * c.abx + (static_cast<float>(group.y) - c.ay) * c.aby +
                      (static_cast<float>(group.z) - c.az) * c.abz;
  const float last = first + static_cast<float>(lanes - 1) * c.abz;
  return first > 0 && last > 0 ? 0 : first > 0 || last > 0 ? 1 : 2;
}

/// Cuts the blocks that must be examined at the current path length, and sets the path length of their next
/// examination. Lists groups that may change within `ahead`.
template <bool capsule>
TYPODONT_INLINE bool carve_due(BallBlocks& b, RemovedVolume* removed) {
  BallFront& f = b.f;
  constexpr int kStretch = SafeTravelRows::kStretch;
  constexpr float kNever = 1e9f;
  const Capsule c = f.c;
  const float from = c.continues ? 0.0f : -1e30f;
  const float length = std::sqrt(c.abx * c.abx + c.aby * c.aby + c.abz * c.abz);
  const float outer = c.radius + Sweep::kMargin, enough = b.path_length + b.ahead;
  const F8 row_x[2] = {{0, 0, 0, 0, 1, 1, 1, 1}, {2, 2, 2, 2, 3, 3, 3, 3}}, row_y = {0, 1, 2, 3, 0, 1, 2, 3};
  I8 any_raised = {};
  eight::Taken taken{removed};
  b.listed = 0;
  // Prefetches a column's blocks near the ball's surface. These blocks were last read many cuts ago.
  const auto fetch_column = [&](int x0, int y0) {
    const float* const due = b.due + (x0 / kRows) * b.due_x + (y0 / kRows) * b.due_y;
    const float bx = static_cast<float>(f.origin.x + x0) + 1.5f - c.ax - c.abx;
    const float by = static_cast<float>(f.origin.y + y0) + 1.5f - c.ay - c.aby;
    for (int z0 = b.lo.z & ~(kRowLength - 1); z0 <= b.hi.z; z0 += kRowLength) {
      const float bz = static_cast<float>(f.origin.z + z0) + 3.5f - c.az - c.abz;
      const float off = std::sqrt(bx * bx + by * by + bz * bz) - c.radius;
      if (due[z0 / kRowLength] >= enough || off > kHalf + Sweep::kMargin || off < -(kHalf + Sweep::kInner)) continue;
      const float* const block = f.distance + (x0 * b.stride_x + y0 * b.stride_y + z0);
      for (int row = 0; row < 16; ++row) __builtin_prefetch(block + ((row >> 2) * b.stride_x + (row & 3) * b.stride_y));
    }
  };
  for (int x0 = b.lo.x & ~(kRows - 1); x0 <= b.hi.x; x0 += kRows) {
    if (((x0 / kRows + b.first_layer) & (b.parts - 1)) != b.part) continue;
    fetch_column(x0, b.lo.y & ~(kRows - 1));
    for (int y0 = b.lo.y & ~(kRows - 1); y0 <= b.hi.y; y0 += kRows) {
      if (y0 + kRows <= b.hi.y) fetch_column(x0, y0 + kRows);
      float* const due = b.due + (x0 / kRows) * b.due_x + (y0 / kRows) * b.due_y;
      const float bx = static_cast<float>(f.origin.x + x0) + 1.5f - c.ax - c.abx;
      const float by = static_cast<float>(f.origin.y + y0) + 1.5f - c.ay - c.aby;
      float u[16], v[16];
      bool rows_known = false;
      for (int stretch = b.lo.z & ~(kRowLength - 1); stretch <= b.hi.z; stretch += kStretch) {
        std::uint64_t live[16] = {};
        SafeTravelRows safe_travel_of;
        bool listed = false;
        const int end = std::min(b.hi.z, stretch + kStretch - 1);
        for (int z0 = stretch; z0 <= end; z0 += kRowLength) {
          float& block_due = due[z0 / kRowLength];
          if (block_due >= enough) continue;
          const float bz = static_cast<float>(f.origin.z + z0) + 3.5f - c.az - c.abz;
          const float away = std::sqrt(bx * bx + by * by + bz * bz) - (kHalf + outer + b.slip);
          if (away - length >= b.ahead) {
            block_due = b.path_length + away;
            continue;
          }
          const bool whole = x0 >= b.held_lo.x && y0 >= b.held_lo.y && z0 >= b.held_lo.z &&
                             x0 + kRows - 1 <= b.held_hi.x && y0 + kRows - 1 <= b.held_hi.y &&
                             z0 + kRowLength - 1 <= b.held_hi.z;
          // The sample in the middle shows whether the block can change, because distance and depth change by at most 1
          // per voxel.
          if (whole) {
            const float middle = f.distance[(x0 + 1) * b.stride_x + (y0 + 1) * b.stride_y + z0 + 3];
            const float least = middle - kHalf - b.slip, safe_travel = least - (length - Sweep::kMargin - away);
            if (least >= Sweep::kInner || safe_travel >= b.ahead) {
              block_due = least >= Sweep::kInner ? kNever : b.path_length + safe_travel;
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
          const F8 first_terms = *reinterpret_cast<const F8*>(f.heights.apart + z0);
          const F8 second_terms = *reinterpret_cast<const F8*>(f.heights.ahead + z0);
          F8 min_safe_travel = F8{} + kNever;
          for (int row = 0; row < 16; ++row) {
            const int x = x0 + (row >> 2), y = y0 + (row & 3);
            if (!whole && (x < b.lo.x || x > b.hi.x || y < b.lo.y || y > b.hi.y)) continue;
            const int first = x * b.stride_x + y * b.stride_y + z0;
            float* const at = f.distance + first;
            const F8 old = *reinterpret_cast<const F8*>(at);
            F8 depth;
            I8 ahead;
            depth_of_eight<capsule>(c, from, F8{} + u[row], F8{} + v[row], first_terms, second_terms, depth, ahead);
            F8 least;
            I8 raised;
            const F8 now = eight::raised_to(old, depth, ahead, least, raised);
            *reinterpret_cast<F8*>(at) = now;
            any_raised |= raised;
            const I8 lost = eight::share_taken(old, now);
            if (any_of(lost > 0)) taken.add(lost, b.tissue + first, at, 0, 8);
            // Distance by which the ball may approach until a sample changes. Samples of the value kInner never change.
            F8 safe_travel = (raised ? now : least) - depth;
            safe_travel = now >= Sweep::kInner ? F8{} + kNever : safe_travel;
            min_safe_travel = safe_travel < min_safe_travel ? safe_travel : min_safe_travel;
            safe_travel_of.put(row, z0 - stretch, safe_travel);
            live[row] |= static_cast<std::uint64_t>(bits_of(safe_travel < b.ahead + b.slip)) << (z0 - stretch);
            __builtin_prefetch(b.tissue + first);  // prefetches the labels, which are needed soon for the list
          }
          float safe_travel = min_safe_travel[0];
          for (int i = 1; i < 8; ++i) safe_travel = std::min(safe_travel, min_safe_travel[i]);
          block_due = whole ? b.path_length + (safe_travel - b.slip) : b.path_length;
          listed = true;
        }
        if (!listed || !(b.ahead > 0)) continue;
        for (int row = 0; row < 16; ++row) {
          for (std::uint64_t rest = live[row]; rest != 0;) {
            const int z = std::countr_zero(rest), x = x0 + (row >> 2), y = y0 + (row & 3);
            const int at = x * b.stride_x + y * b.stride_y + stretch + z;
            std::uint8_t label;
            const std::uint64_t from_here = rest >> z;
            int samples = with_one_label(b.tissue + at, f.distance + at, b.lanes, label);
            rest &= z + samples < kStretch ? ~std::uint64_t{0} << (z + samples) : 0;
            const bool narrow = b.lanes > CutFront::kNarrowest &&
                                (from_here & ((std::uint64_t{1} << samples) - 1)) >> CutFront::kNarrowest == 0;
            if (narrow) samples = std::min(samples, CutFront::kNarrowest);
            b.found[std::min(b.listed++, b.capacity)] = {
                static_cast<float>(x),
                static_cast<float>(y),
                stretch + z,
                at,
                side_of(c, f.origin + glm::ivec3(x, y, stretch + z), narrow ? CutFront::kNarrowest : b.lanes),
                stage_of(safe_travel_of.least(row, z, from_here) - b.slip, b.ahead),
                narrow,
                static_cast<std::uint8_t>(samples),
                label};
          }
        }
      }
    }
  }
  taken.close();
  return any_of(any_raised);
}

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool carve_due_here(BallBlocks* blocks, bool capsule, RemovedVolume* removed) {
  return capsule ? carve_due<true>(*blocks, removed) : carve_due<false>(*blocks, removed);
}

}  // namespace

bool Sweep::carve_ball(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                       std::size_t stride_y, const Tissue* tissue, RemovedVolume* removed) const noexcept {
  const Capsule capsule{a_.x, a_.y, a_.z, ab_.x, ab_.y, ab_.z, inverse_length2_, radius_, continues_};
  const glm::ivec3 from = lo - base_;
  const Block block{distance, tissue, stride_x, stride_y, from.x, from.y, from.z, size.x, size.y, size.z};
  return carve_block_here(&block, &capsule, !is_ball(), removed);
}

bool Sweep::carve_ball(CutFront& front, const glm::ivec3& patch_lo, int n, float* distance, const Tissue* tissue,
                       RemovedVolume* removed) const noexcept {
  front.keep_listed(patch_lo, n, holds_listed(patch_lo, n));
  const glm::ivec3 origin = front.first_ * glm::ivec3(CutFront::kRows, CutFront::kRows, CutFront::kRowLength);
  const glm::ivec3 held = patch_lo - origin;
  const std::ptrdiff_t at = -((static_cast<std::ptrdiff_t>(held.x) * n + held.y) * n + held.z);
  // The table of heights is longer in z than the sweep's box, because groups and listed samples may lie outside it.
  const int heights_from = std::max(((lo_.z - 1 - origin.z) & ~7) - 8, 0);
  const int heights_to = std::min(((hi_.z + 1 - origin.z) | 7) + 8, front.size_.z * CutFront::kRowLength) + 16;
  BallBlocks b{.f = {.c = {a_.x, a_.y, a_.z, ab_.x, ab_.y, ab_.z, inverse_length2_, radius_, continues_},
                     .origin = origin - base_,
                     .distance = distance + at,
                     .heights = {front.heights(0), front.heights(1)},
                     .groups = {},
                     .wide = {},
                     .narrow = {}},
               .tissue = tissue + at,
               .stride_x = n * n,
               .stride_y = n,
               .lo = lo_ - 1 - origin,
               .hi = hi_ + 1 - origin,
               .held_lo = held,
               .held_hi = held + n - 1,
               .due = front.due_.data(),
               .due_x = front.size_.y * front.size_.z,
               .due_y = front.size_.z,
               .path_length = static_cast<float>(front.path_length_),
               .ahead = 0,
               .slip = 1e-3f + 2e-6f * (radius_ + kMargin),
               .lanes = front.lanes_,
               .parts = front.parts(),
               .part = 0,
               .first_layer = front.part_of(0),
               .found = nullptr,
               .listed = 0,
               .capacity = front.parts_[0].capacity()};
  const bool capsule = !is_ball();
  fill_heights(&b.f, capsule, heights_from, heights_to);
  CutFront::Renewal renewal(front, front.reached(lo_, hi_), travel_, CutFront::kListedOfBall);
  bool changed = false;
  for (int part = 0; part < front.parts(); ++part) {
    CutFront::Groups& groups = front.parts_[static_cast<std::size_t>(part)];
    if (renewal.keeps(part)) {
      b.f.groups = groups.listed();
      b.f.wide.count = b.f.narrow.count = 0;
      const int stage = groups.stage(front.path_length_);
      for (int r = 0, side = -1; r < groups.run_count; ++r) {
        const CutFront::Run& run = groups.runs[static_cast<std::size_t>(r)];
        if (run.stage > stage) continue;
        BallFront::Ranges& ranges = run.narrow ? b.f.narrow : b.f.wide;
        const int this_side = 2 * run.kind + run.narrow;
        if (this_side != side) ranges.at[ranges.count++] = {run.from, run.to};
        ranges.at[ranges.count - 1].to = run.to;
        side = this_side;
      }
      changed |= carve_listed_ball(b.f, capsule, front.lanes_, removed);
      continue;
    }
    const double lasts = renewal.lasts(part);
    b.part = part;
    b.ahead = static_cast<float>(lasts);
    b.found = groups.found.data();
    changed |= carve_due_here(&b, capsule, removed);
    groups.until = -1;
    groups.count = 0;
    if (lasts > 0) groups.renew(b.listed, front.path_length_, lasts);
  }
  return changed;
}

}  // namespace typodont::haptics
