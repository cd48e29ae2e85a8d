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
  double sum = 0;
  std::size_t label = 0;

  /// Of eight samples: shares before less after.
  TYPODONT_KERNEL void add(const F8& was, const F8& is, const Tissue* labels) {
    F8 taken, after;
    shares_inside(was, taken);
    shares_inside(is, after);
    taken -= after;
    std::uint64_t eight;
    std::memcpy(&eight, labels, sizeof eight);
    if (eight == (eight & 0xff) * 0x0101010101010101u) {
      if ((eight & 0xff) != label) {
        close();
        label = eight & 0xff;
      }
      sum += static_cast<double>(sum_of(taken));
    } else {
      for (int i = 0; i < 8; ++i) add(static_cast<double>(taken[i]), labels[i]);
    }
  }
  void add(double taken, Tissue tissue) { (*removed)[static_cast<std::size_t>(tissue)] += taken; }
  void close() {
    (*removed)[label] += sum;
    sum = 0;
  }
};

/// Eight samples along z that a sweep may raise.
struct Group {
  std::int32_t at;  // of the first, in samples
  float z;          // its height, from base
  float u, v;       // what its row has in common: see raise_block()
};
static_assert(sizeof(Group) == 16);

constexpr int kGroups = 512;  // looked at together

/// Raises the samples of some groups: new = max(old, min(radius - distance, kInner)), wherever that is above -kMargin.
/// `narrow`: rows are shorter than a group.
template <bool capsule, bool narrow>
TYPODONT_KERNEL bool raise_groups(const Block& block, const Capsule& c, const Group* groups,
                                                        int count, PerTissue* removed) {
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7};
  const float az = c.az, abx = c.abx, aby = c.aby, abz = c.abz, inverse_length2 = c.inverse_length2, radius = c.radius;
  const float from = c.continues ? 0.0f : -1e30f;
  float* const distance = block.distance;
  const int size_z = block.size_z;
  F8 moved_old[kGroups];  // groups in which surface moved: what they held before
  std::int32_t moved_at[kGroups];
  int moved = 0;
  I8 any_raised = {};
  for (int g = 0; g < count; ++g) {
    const Group group = groups[g];
    float* const at = distance + group.at;
    F8 old;
    if constexpr (!narrow) {
      old = *reinterpret_cast<const F8*>(at);
    } else {
      for (int i = 0; i < 8; ++i) old[i] = i < size_z ? at[i] : 1e9f;
    }
    const F8 z = group.z + steps - az;  // the same rounding wherever rows start
    F8 dot, d2;
    if constexpr (capsule) {
      const float px = group.u, py = group.v;
      dot = (px * abx + py * aby) + z * abz;
      F8 s = dot * inverse_length2;
      s = s < 0.0f ? F8{} : s;
      s = s > 1.0f ? F8{} + 1.0f : s;
      const F8 dx = px - s * abx, dy = py - s * aby, dz = z - s * abz;
      d2 = dx * dx + dy * dy + dz * dz;
    } else {
      dot = group.v + z * abz;
      const F8 dz = z - abz;
      d2 = group.u + dz * dz;
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
    moved_at[moved] = group.at;
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
  return any_of(any_raised);
}

/// Eight rows' groups from four vectors of their parts.
TYPODONT_KERNEL void transpose(const I8& at, const F8& z, const F8& u, const F8& v,
                                                     I4 (&groups)[8]) {
  const I8 zi = (I8)z, ui = (I8)u, vi = (I8)v;
  const I8 az0 = __builtin_shufflevector(at, zi, 0, 8, 1, 9, 4, 12, 5, 13);
  const I8 az1 = __builtin_shufflevector(at, zi, 2, 10, 3, 11, 6, 14, 7, 15);
  const I8 uv0 = __builtin_shufflevector(ui, vi, 0, 8, 1, 9, 4, 12, 5, 13);
  const I8 uv1 = __builtin_shufflevector(ui, vi, 2, 10, 3, 11, 6, 14, 7, 15);
  groups[0] = __builtin_shufflevector(az0, uv0, 0, 1, 8, 9);
  groups[1] = __builtin_shufflevector(az0, uv0, 2, 3, 10, 11);
  groups[2] = __builtin_shufflevector(az1, uv1, 0, 1, 8, 9);
  groups[3] = __builtin_shufflevector(az1, uv1, 2, 3, 10, 11);
  groups[4] = __builtin_shufflevector(az0, uv0, 4, 5, 12, 13);
  groups[5] = __builtin_shufflevector(az0, uv0, 6, 7, 14, 15);
  groups[6] = __builtin_shufflevector(az1, uv1, 4, 5, 12, 13);
  groups[7] = __builtin_shufflevector(az1, uv1, 6, 7, 14, 15);
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
  Group groups[kGroups + 16];
  int count = 0;
  for (int x = 0; x < block.size_x; ++x) {
    const float px = static_cast<float>(block.lo_x + x) - c.ax;
    if (!(reach2 > (px - mx) * (px - mx))) continue;
    const auto base_x = static_cast<std::int32_t>(static_cast<std::size_t>(x) * block.stride_x);
    for (int y0 = 0; y0 < block.size_y; y0 += 8) {
      if (count > kGroups - 16) {
        changed |= raise_groups<capsule, narrow>(block, c, groups, count, removed);
        count = 0;
      }
      // Of eight rows: what can change, as an interval [low, high), and the hole in it.
      const I8 y = y0 + counts;
      const F8 py = static_cast<float>(block.lo_y + y0) + steps - c.ay, qy = py - my;
      const F8 dot_xy = px * c.abx + py * c.aby;
      const F8 u = capsule ? F8{} + px : (px - mx) * (px - mx) + qy * qy, v = capsule ? py : dot_xy;
      F8 half = reach2 - (px - mx) * (px - mx) - qy * qy;
      const I8 met = (half > 0.0f) & (y < block.size_y);
      half = met ? half : F8{};
      take_root(half);
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
      high = met & (low < high) ? high : F8{};
      low = high > 0.0f ? low : F8{};
      F8 hole = inner2 - px * px - py * py;
      hole = hole > 0.0f ? hole : F8{};
      take_root(hole);
      F8 hole_from = first + 1.0f - hole, hole_to = first + 1.0f + hole;
      const I8 leave = hole_to - hole_from > 8.0f;  // only worth leaving out when a whole group fits
      hole_from = leave & (hole_from > 0.0f) ? hole_from : leave ? F8{} : high;
      hole_to = leave & (hole_to > 0.0f) ? hole_to : leave ? F8{} : high;
      I8 from = __builtin_convertvector(low, I8);
      const I8 a_to = __builtin_convertvector(hole_from < high ? hole_from : high, I8);
      const I8 b_from = __builtin_convertvector(hole_to > low ? hole_to : low, I8);
      const I8 to = __builtin_convertvector(high, I8);
      // Most rows are one stretch of at most sixteen: without a branch, whether one group or two.
      const I8 stretch_a = a_to > from, stretch_b = to > b_from;
      from = stretch_a ? from : b_from;
      const I8 stop = stretch_a ? a_to : to;
      const I8 second = from + 8, at0 = from < last_start ? from : I8{} + last_start;
      const I8 at1 = second < last_start ? second : I8{} + last_start;
      const I8 base = base_x + y * stride_y;
      const I8 some = (stretch_a | stretch_b) & 1, more = (second < stop) & 1;
      I4 one[8], two[8];
      transpose(base + at0, __builtin_convertvector(block.lo_z + at0, F8), u, v, one);
      transpose(base + at1, __builtin_convertvector(block.lo_z + at1, F8), u, v, two);
      for (int row = 0; row < 8; ++row) {
        *reinterpret_cast<I4*>(&groups[count]) = one[row];
        count += some[row];
        *reinterpret_cast<I4*>(&groups[count]) = two[row];
        count += more[row];
      }
      const I8 rest = (second + 8 < stop) | (stretch_a & stretch_b);
      if (!any_of(rest)) continue;
      for (int row = 0; row < 8; ++row) {
        if (!rest[row]) continue;
        const auto put_all = [&](int start, int until) __attribute__((always_inline)) {
          for (; start < until; start += 8) {
            if (count >= kGroups) {
              changed |= raise_groups<capsule, narrow>(block, c, groups, count, removed);
              count = 0;
            }
            const int at = start < last_start ? start : last_start;
            groups[count++] = {base[row] + at, static_cast<float>(block.lo_z + at), u[row], v[row]};
          }
        };
        put_all(second[row] + 8, stop[row]);
        if (stretch_a[row]) put_all(b_from[row], to[row]);
      }
    }
  }
  changed |= raise_groups<capsule, narrow>(block, c, groups, count, removed);
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
using HeadPiece = std::array<float, 10>;

struct HeadBlock {
  float px, py, pz;           // of its first sample, in T
  float ex[3], ey[3], ez[3];  // to the next sample along x, y, z
};

/// How far each sample of a block is from its centre, and a little more.
struct Offsets {
  float of[kRows * kRows][kDeep];
  Offsets() {
    for (int row = 0; row < kRows * kRows; ++row) {
      for (int i = 0; i < kDeep; ++i) {
        const glm::dvec3 d(row / kRows - (kRows - 1) / 2.0, row % kRows - (kRows - 1) / 2.0, i - (kDeep - 1) / 2.0);
        of[row][i] = static_cast<float>(glm::length(d) + 1e-3);
      }
    }
  }
};
const Offsets kOffsets;

/// The rows of a block that a head may raise whose depth at the block's centre is `depth`: it changes by at most one
/// per voxel. One bit per row; arguments as for raise_rows().
TYPODONT_DISPATCH("avx2", "default")
unsigned rows_to_raise(const float* distance, std::ptrdiff_t first, std::size_t stride_x, std::size_t stride_y,
                       float depth, const int* from, const int* to) {
  unsigned rows = 0;
  const bool whole = from[2] == 0 && to[2] == kDeep;
  for (int x = from[0]; x < to[0]; ++x) {
    for (int y = from[1]; y < to[1]; ++y) {
      const std::ptrdiff_t at =
          first + x * static_cast<std::ptrdiff_t>(stride_x) + y * static_cast<std::ptrdiff_t>(stride_y);
      F8 most = *reinterpret_cast<const F8*>(kOffsets.of[x * kRows + y]) + depth;
      most = most > Sweep::kInner ? F8{} + Sweep::kInner : most;
      F8 old = F8{} + 1e9f;
      if (whole) {
        old = *reinterpret_cast<const F8*>(distance + at);
      } else {
        for (int i = from[2]; i < to[2]; ++i) old[i] = distance[at + i];
      }
      if (any_of((most > old) & (most > -Sweep::kMargin))) rows |= 1u << (x * kRows + y);
    }
  }
  return rows;
}

/// Depth of the samples of a block in a head at one pose, or what `depth` holds where that is more. `which` lists the
/// pieces of the meridian that can be the closest one to any of the samples.
TYPODONT_DISPATCH("avx2", "default")
void deepen_block(F8* depth, const HeadBlock* block, const HeadPiece* pieces, const int* which, int piece_count,
                  unsigned rows) {
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7};
  const F8 along_x = steps * block->ez[0], along_y = steps * block->ez[1], along_z = steps * block->ez[2];
  for (int row = 0; row < kRows * kRows; ++row) {
    if (!(rows >> row & 1)) continue;
    const float ix = static_cast<float>(row / kRows), iy = static_cast<float>(row % kRows);
    const F8 x = (block->px + ix * block->ex[0] + iy * block->ey[0]) + along_x;
    const F8 y = (block->py + ix * block->ex[1] + iy * block->ey[1]) + along_y;
    const F8 z = (block->pz + ix * block->ex[2] + iy * block->ey[2]) + along_z;
    F8 rho = x * x + y * y;
    take_root(rho);
    F8 best = F8{} + 1e30f;
    I8 outside = {};
    for (int p = 0; p < piece_count; ++p) {
      const HeadPiece& piece = pieces[which[p]];
      const float ax = piece[0], az = piece[1], dx = piece[4], dz = piece[5], radius = piece[9];
      const F8 ex = rho - ax, ez = z - az;
      const I8 beyond = dx * ez - dz * ex < 0.0f;
      if (radius == 0.0f) {
        F8 s = (ex * dx + ez * dz) * piece[6];
        s = s < 0.0f ? F8{} : s;
        s = s > 1.0f ? F8{} + 1.0f : s;
        const F8 fx = ex - s * dx, fz = ez - s * dz, d2 = fx * fx + fz * fz;
        best = d2 < best ? d2 : best;
        outside |= beyond;
      } else {
        const float bx = piece[2], bz = piece[3], cx = piece[7], cz = piece[8];
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
    const F8 signed_depth = outside ? -best : best;
    depth[row] = signed_depth > depth[row] ? signed_depth : depth[row];
  }
}

/// new = max(old, min(depth, kInner)), depths below -kMargin not counted, for the part [from, to) of a block. `row` is
/// the block's first sample, inside the array or not. Returns whether anything changed.
TYPODONT_DISPATCH("avx2", "default")
bool raise_rows(float* distance, std::ptrdiff_t row, std::size_t stride_x, std::size_t stride_y, const F8* depths,
                const int* from, const int* to, const Tissue* tissue, PerTissue* removed) {
  bool changed = false;
  const bool whole = from[2] == 0 && to[2] == kDeep;
  for (int x = from[0]; x < to[0]; ++x) {
    for (int y = from[1]; y < to[1]; ++y) {
      const std::ptrdiff_t at =
          row + x * static_cast<std::ptrdiff_t>(stride_x) + y * static_cast<std::ptrdiff_t>(stride_y);
      F8 depth = depths[x * kRows + y];
      depth = depth > Sweep::kInner ? F8{} + Sweep::kInner : depth;
      depth = depth > -Sweep::kMargin ? depth : F8{} - 1e9f;
      F8 old = F8{} + 1e9f;  // what lies outside the part is not raised
      if (whole) {
        old = *reinterpret_cast<const F8*>(distance + at);
      } else {
        for (int i = from[2]; i < to[2]; ++i) old[i] = distance[at + i];
      }
      const I8 raised = depth > old;
      if (!any_of(raised)) continue;
      changed = true;
      const F8 now = raised ? depth : old;
      if (whole) {
        *reinterpret_cast<F8*>(distance + at) = now;
      } else {
        for (int i = from[2]; i < to[2]; ++i) distance[at + i] = now[i];
      }
      if (removed && any_of(raised & (now > -0.5f) & (old < 0.5f))) {
        Account account{removed};
        if (whole) {
          account.add(old, now, tissue + at);
          account.close();
        } else {
          for (int i = from[2]; i < to[2]; ++i) {
            account.add(static_cast<double>(share_inside(old[i]) - share_inside(now[i])), tissue[at + i]);
          }
        }
      }
    }
  }
  return changed;
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
  const Block block{distance, tissue, stride_x, stride_y, from.x, from.y, from.z, size.x, size.y, size.z};
  // Between capsule and balls lies ab²/8r: nothing, for a short step that continues another.
  const float length2 = glm::dot(ab_, ab_);
  return continues_ && length2 < 8e-5f * radius_ ? raise_ball_ahead(&block, &capsule, removed)
                                                 : raise_capsule(&block, &capsule, removed);
}

bool Sweep::raise_head(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                       std::size_t stride_y, const Tissue* tissue, PerTissue* removed) const noexcept {
  bool changed = false;
  HeadPiece pieces[HeadField::kMaxPieces];
  for (int p = 0; p < head_.count; ++p) {
    const HeadField::Piece& piece = head_.pieces[p];
    const double values[10] = {piece.ax, piece.az,       piece.bx, piece.bz, piece.dx,
                               piece.dz, piece.inverse2, piece.cx, piece.cz, piece.radius};
    for (std::size_t i = 0; i < 10; ++i) pieces[p][i] = static_cast<float>(values[i]);
  }
  // Blocks are aligned to the voxel grid, so that a sample's depth does not depend on how the work was cut up.
  const auto down = [](int v, int step) { return v - (v % step + step) % step; };
  const dvec3 middle = dvec3(kRows - 1, kRows - 1, kDeep - 1) / 2.0;
  const double half = glm::length(middle) + 1e-3;
  const int last = poses_;
  const glm::dmat3 R_AV = glm::transpose(glm::dmat3(X_VA_.R)), R_BV = glm::transpose(glm::dmat3(X_VB_.R));
  for (int x0 = down(lo.x, kRows); x0 < lo.x + size.x; x0 += kRows) {
    for (int y0 = down(lo.y, kRows); y0 < lo.y + size.y; y0 += kRows) {
      for (int z0 = down(lo.z, kDeep); z0 < lo.z + size.z; z0 += kDeep) {
        const dvec3 origin(x0, y0, z0);
        int from[3], to[3];
        const int block_lo[3] = {x0, y0, z0}, extent[3] = {kRows, kRows, kDeep};
        for (int i = 0; i < 3; ++i) {
          from[i] = std::max(lo[i] - block_lo[i], 0);
          to[i] = std::min(lo[i] + size[i] - block_lo[i], extent[i]);
        }
        const std::ptrdiff_t row = (x0 - lo.x) * static_cast<std::ptrdiff_t>(stride_x) +
                                   (y0 - lo.y) * static_cast<std::ptrdiff_t>(stride_y) + (z0 - lo.z);
        F8 depth[kRows * kRows];
        bool any = false;
        for (int k = continues_ ? 1 : 0; k <= last; ++k) {
          const Pose X_VT = k == 0 ? X_VA_ : k == last ? X_VB_ : pose(k);
          const glm::dmat3 R_TV = k == 0 ? R_AV : k == last ? R_BV : glm::transpose(glm::dmat3(X_VT.R));
          const dvec3 first = R_TV * (origin - X_VT.p), center = first + R_TV * middle;
          double to_piece[HeadField::kMaxPieces];
          const double distance_center = head_.distance(center, to_piece);
          if (distance_center > kMargin + half) continue;
          // Deep in the head at A too: empty since then.
          if (continues_ && distance_center < -(kInner + half + travel_)) continue;
          const unsigned rows =
              rows_to_raise(distance, row, stride_x, stride_y, static_cast<float>(-distance_center), from, to);
          if (rows == 0) continue;
          int which[HeadField::kMaxPieces], piece_count = 0;
          for (int p = 0; p < head_.count; ++p) {
            if (to_piece[p] < std::abs(distance_center) + 2 * half) which[piece_count++] = p;
          }
          if (!any) {
            for (int i = 0; i < kRows * kRows; ++i) depth[i] = F8{} - 1e9f;
          }
          any = true;
          const glm::vec3 p(first), ex(R_TV[0]), ey(R_TV[1]), ez(R_TV[2]);
          const HeadBlock block{p.x, p.y, p.z, {ex.x, ex.y, ex.z}, {ey.x, ey.y, ey.z}, {ez.x, ez.y, ez.z}};
          deepen_block(depth, &block, pieces, which, piece_count, rows);
        }
        if (!any) continue;
        changed |= raise_rows(distance, row, stride_x, stride_y, depth, from, to, tissue, removed);
      }
    }
  }
  return changed;
}

}  // namespace typodont::haptics
