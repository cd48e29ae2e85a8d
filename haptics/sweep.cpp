#include "haptics/sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/base/dispatch.h"

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

typedef float F8 __attribute__((vector_size(32), aligned(4), may_alias));
typedef int I8 __attribute__((vector_size(32), aligned(4)));

typedef long long L4 __attribute__((vector_size(32), aligned(4)));

inline bool any_of(const I8& mask) {
  const L4 m = (L4)mask;
  return (m[0] | m[1] | m[2] | m[3]) != 0;
}

struct Block {
  float* distance;
  const Tissue* tissue;
  std::size_t stride_x, stride_y;
  int lo_x, lo_y, lo_z;  // from base
  int size_x, size_y, size_z;
};

/// Volume taken from one row: shares before less after, by label.
inline __attribute__((always_inline)) void account(const float* was, const float* is, const Tissue* labels, int count,
                                                   PerTissue& removed) {
  for (int start = 0; start < count; start += 8) {
    const int lanes = count - start < 8 ? count - start : 8;
    if (lanes < 8) {
      for (int i = start; i < count; ++i) {
        if (!(is[i] > was[i])) continue;
        removed[static_cast<std::size_t>(labels[i])] += static_cast<double>(share_inside(was[i]) - share_inside(is[i]));
      }
      return;
    }
    F8 before = 0.5f - *reinterpret_cast<const F8*>(was + start),
       after = 0.5f - *reinterpret_cast<const F8*>(is + start);
    before = before > 1.0f ? F8{} + 1.0f : before < 0.0f ? F8{} : before;
    after = after > 1.0f ? F8{} + 1.0f : after < 0.0f ? F8{} : after;
    const F8 taken = before - after;
    if (!any_of(taken != 0.0f)) continue;
    std::uint64_t eight;
    std::memcpy(&eight, labels + start, sizeof eight);
    if (eight == (eight & 0xff) * 0x0101010101010101u) {
      const float sum =
          ((taken[0] + taken[1]) + (taken[2] + taken[3])) + ((taken[4] + taken[5]) + (taken[6] + taken[7]));
      removed[eight & 0xff] += static_cast<double>(sum);
    } else {
      for (int i = 0; i < 8; ++i) removed[static_cast<std::size_t>(labels[start + i])] += static_cast<double>(taken[i]);
    }
  }
}

/// Raises a block of samples: new = max(old, min(radius - distance, kInner)), wherever the distance is above -kMargin.
/// `capsule` false: the sweep is so short that the ball at B, ahead of A, is all of it. Returns whether anything
/// changed; volume taken is added to `removed`, where given.
template <bool capsule>
inline __attribute__((always_inline)) bool raise_block(const Block block, const Capsule c, PerTissue* removed) {
  const float outer = c.radius + Sweep::kMargin;
  const float length = std::sqrt(c.abx * c.abx + c.aby * c.aby + c.abz * c.abz);
  // Inside this ball around A all is empty already when the sweep continues another.
  const float inner = c.continues ? c.radius - Sweep::kInner - 0.01f : 0.0f, inner2 = inner > 0 ? inner * inner : -1.0f;
  const float row_reach = outer + 0.5f * length, row_reach2 = row_reach * row_reach;
  const float mx = 0.5f * c.abx, my = 0.5f * c.aby, mz = 0.5f * c.abz;
  const float from = c.continues ? 0.0f : -1e30f;
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7};
  bool changed = false;
  constexpr int kGroups = 32;  // of a row looked at together
  float before[kGroups * 8];
  for (int x = 0; x < block.size_x; ++x) {
    const float px = static_cast<float>(block.lo_x + x) - c.ax;
    for (int y = 0; y < block.size_y; ++y) {
      const float py = static_cast<float>(block.lo_y + y) - c.ay;
      // The part of the row that can change: inside the ball around the sweep, ahead of A when it continues.
      const float reach2 = row_reach2 - (px - mx) * (px - mx) - (py - my) * (py - my);
      if (!(reach2 > 0)) continue;
      const float reach = std::sqrt(reach2), first = c.az - static_cast<float>(block.lo_z);  // A on this row
      const float dot_xy = px * c.abx + py * c.aby;
      float low = first + mz - reach, high = first + mz + reach;
      if (c.continues) {
        if (c.abz > 1e-9f) {
          const float edge = first - dot_xy / c.abz - 1;
          low = edge > low ? edge : low;
        } else if (c.abz < -1e-9f) {
          const float edge = first - dot_xy / c.abz + 1;
          high = edge < high ? edge : high;
        }
      }
      const float top = static_cast<float>(block.size_z - 1);
      low = low > 0 ? low : 0;
      high = high < top ? high : top;
      if (!(low <= high)) continue;
      int gap_from = 1 << 30, gap_to = 1 << 30;  // groups that lie wholly in the empty ball are passed over
      const float hole2 = inner2 - px * px - py * py;
      if (hole2 > 0) {
        const float hole = std::sqrt(hole2);
        gap_from = first > hole ? static_cast<int>(first - hole + 1) : 0, gap_to = static_cast<int>(first + hole);
      }
      float* const row =
          block.distance + static_cast<std::size_t>(x) * block.stride_x + static_cast<std::size_t>(y) * block.stride_y;
      // Groups of eight stay inside the row; looking at a sample twice is harmless.
      const int end = static_cast<int>(high) + 1, last_start = block.size_z > 8 ? block.size_z - 8 : 0;
      const float bx = px - c.abx, by = py - c.aby, bxy2 = bx * bx + by * by;
      for (int next = static_cast<int>(low); next < end;) {
        if (next >= gap_from && next + 8 <= gap_to) {
          next = gap_to;
          continue;
        }
        const int run = next <= last_start ? next : last_start;
        int groups = 0;
        I8 any_changed = {}, any_crossing = {};
        for (; next < end && groups < kGroups && !(next >= gap_from && next + 8 <= gap_to); next += 8, ++groups) {
          const int start = run + 8 * groups <= last_start ? run + 8 * groups : last_start;
          F8 old;
          if (block.size_z >= 8) {
            old = *reinterpret_cast<const F8*>(row + start);
          } else {
            for (int i = 0; i < 8; ++i) old[i] = i < block.size_z ? row[i] : 1e9f;
          }
          const F8 z = static_cast<float>(block.lo_z + start) + steps - c.az;  // the same rounding wherever rows start
          const F8 dot = dot_xy + z * c.abz;
          const I8 ahead = dot > from;
          F8 d2;
          if constexpr (capsule) {
            F8 s = dot * c.inverse_length2;
            s = s < 0.0f ? F8{} : s;
            s = s > 1.0f ? F8{} + 1.0f : s;
            const F8 dx = px - s * c.abx, dy = py - s * c.aby, dz = z - s * c.abz;
            d2 = dx * dx + dy * dy + dz * dz;
          } else {
            const F8 dz = z - c.abz;
            d2 = bxy2 + dz * dz;
          }
          F8 root;
          for (int i = 0; i < 8; ++i) root[i] = std::sqrt(d2[i]);
          F8 depth = c.radius - root;
          depth = depth > Sweep::kInner ? F8{} + Sweep::kInner : depth;
          const I8 raised = ahead & (depth > -Sweep::kMargin) & (depth > old);
          const F8 now = raised ? depth : old;
          *reinterpret_cast<F8*>(before + 8 * groups) = old;
          if (block.size_z >= 8) {
            *reinterpret_cast<F8*>(row + start) = now;
          } else {
            for (int i = 0; i < block.size_z; ++i) row[i] = now[i];
          }
          any_changed |= raised;
          any_crossing |= raised & (now > -0.5f) & (old < 0.5f);
        }
        changed |= any_of(any_changed);
        if (removed && any_of(any_crossing)) {
          for (int g = 0; g < groups; ++g) {
            const int start = run + 8 * g <= last_start ? run + 8 * g : last_start;
            account(before + 8 * g, row + start, block.tissue + (row - block.distance) + start,
                    block.size_z < 8 ? block.size_z : 8, *removed);
          }
        }
      }
    }
  }
  return changed;
}

// Compiled twice and chosen at run time. Every sample is computed by itself and FMA is off for the whole program, so
// that every processor, and every way of cutting the work into rows, gives the same bits.
TYPODONT_DISPATCH("avx2", "default")
bool raise_capsule(const Block* block, const Capsule* capsule, PerTissue* removed) {
  return raise_block<true>(*block, *capsule, removed);
}
TYPODONT_DISPATCH("avx2", "default")
bool raise_ball_ahead(const Block* block, const Capsule* capsule, PerTissue* removed) {
  return raise_block<false>(*block, *capsule, removed);
}

constexpr int kRows = 4, kDeep = 8;  // a block of a general head's sweep: kRows × kRows rows of kDeep samples
using HeadPiece = std::array<float, 10>;

struct HeadBlock {
  float px, py, pz;           // of its first sample, in T
  float ex[3], ey[3], ez[3];  // to the next sample along x, y, z
};

inline __attribute__((always_inline)) void take_root(F8& v) {
  F8 root;
  for (int i = 0; i < 8; ++i) root[i] = std::sqrt(v[i]);
  v = root;
}

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
        float before[kDeep], after[kDeep];
        *reinterpret_cast<F8*>(before) = old;
        *reinterpret_cast<F8*>(after) = now;
        account(before + from[2], after + from[2], tissue + at + from[2], to[2] - from[2], *removed);
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
