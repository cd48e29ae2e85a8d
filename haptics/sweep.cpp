#include "haptics/sweep.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

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

  const double reach = tool.reach() / frame.voxel + kMargin;
  lo_ = glm::ivec3(glm::ceil(glm::min(a, b) - reach));
  hi_ = glm::ivec3(glm::floor(glm::max(a, b) + reach));

  // Two poses s apart leave a scallop of s²/8r on a flank of radius r; turning moves the far end by angle × reach.
  const double turn = 2 * std::acos(std::min(1.0, std::abs(glm::dot(X_WA.R, X_WB.R))));
  const double travel = glm::length(b - a) + turn * tool.reach() / frame.voxel;
  const double step = std::sqrt(8 * std::max(1.0, static_cast<double>(radius_)) * 0.01);
  poses_ = std::clamp(static_cast<int>(std::ceil(travel / step)), 1, 512);
}

Pose Sweep::pose(int k) const noexcept { return interpolate(X_VA_, X_VB_, static_cast<double>(k) / poses_); }

namespace {

/// Share of a voxel inside a surface that passes `distance` voxels from its centre.
inline float share_inside(float distance) { return std::clamp(0.5f - distance, 0.0f, 1.0f); }

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
    F8 before = 0.5f - *reinterpret_cast<const F8*>(was + start), after = 0.5f - *reinterpret_cast<const F8*>(is + start);
    before = before > 1.0f ? F8{} + 1.0f : before < 0.0f ? F8{} : before;
    after = after > 1.0f ? F8{} + 1.0f : after < 0.0f ? F8{} : after;
    const F8 taken = before - after;
    if (!any_of(taken != 0.0f)) continue;
    std::uint64_t eight;
    std::memcpy(&eight, labels + start, sizeof eight);
    if (eight == (eight & 0xff) * 0x0101010101010101u) {
      const float sum = ((taken[0] + taken[1]) + (taken[2] + taken[3])) + ((taken[4] + taken[5]) + (taken[6] + taken[7]));
      removed[eight & 0xff] += static_cast<double>(sum);
    } else {
      for (int i = 0; i < 8; ++i) removed[static_cast<std::size_t>(labels[start + i])] += static_cast<double>(taken[i]);
    }
  }
}

/// Raises a block of samples: new = max(old, min(radius - distance, kInner)), wherever the distance is above -kMargin.
/// `capsule` false: the sweep is so short that the ball at B, ahead of A, is all of it. Returns whether anything changed;
/// volume taken is added to `removed`, where given.
template <bool capsule>
inline __attribute__((always_inline)) bool raise_block(const Block& block, const Capsule& c, PerTissue* removed) {
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
      float* const row = block.distance + static_cast<std::size_t>(x) * block.stride_x +
                         static_cast<std::size_t>(y) * block.stride_y;
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

// Compiled twice and chosen at run time. Every sample is computed by itself and FMA is off for the whole program, so that
// every processor, and every way of cutting the work into rows, gives the same bits.
__attribute__((target_clones("avx2", "default"))) bool raise_capsule(const Block* block, const Capsule* capsule,
                                                                     PerTissue* removed) {
  return raise_block<true>(*block, *capsule, removed);
}
__attribute__((target_clones("avx2", "default"))) bool raise_ball_ahead(const Block* block, const Capsule* capsule,
                                                                        PerTissue* removed) {
  return raise_block<false>(*block, *capsule, removed);
}

struct Row {
  float px, py, pz;  // of its first sample, in T
  float ex, ey, ez;  // from sample to sample
};

/// Depth of a row of samples in a head at one pose, or what `depth` holds where that is more.
__attribute__((target_clones("avx2", "default"))) void deepen_row(float* depth, int count, const Row* row,
                                                                  const float (*pieces)[10], int piece_count) {
  constexpr int kLanes = 8;
  for (int start = 0; start < count; start += kLanes) {
    float rho[kLanes], z[kLanes], best[kLanes], inside[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      const float k = static_cast<float>(start + i);
      const float x = row->px + k * row->ex, y = row->py + k * row->ey;
      rho[i] = std::sqrt(x * x + y * y);
      z[i] = row->pz + k * row->ez;
      best[i] = 1e30f;
      inside[i] = 1.0f;
    }
    for (int p = 0; p < piece_count; ++p) {
      const float ax = pieces[p][0], az = pieces[p][1], bx = pieces[p][2], bz = pieces[p][3], dx = pieces[p][4],
                  dz = pieces[p][5], inverse2 = pieces[p][6], cx = pieces[p][7], cz = pieces[p][8], radius = pieces[p][9];
      if (radius == 0.0f) {
        for (int i = 0; i < kLanes; ++i) {
          const float ex = rho[i] - ax, ez = z[i] - az;
          float s = (ex * dx + ez * dz) * inverse2;
          s = s < 0.0f ? 0.0f : s;
          s = s > 1.0f ? 1.0f : s;
          const float fx = ex - s * dx, fz = ez - s * dz, d2 = fx * fx + fz * fz;
          best[i] = d2 < best[i] ? d2 : best[i];
          inside[i] = dx * ez - dz * ex < 0.0f ? -1.0f : inside[i];
        }
      } else {
        const float ux = ax - cx, uz = az - cz, wx = bx - cx, wz = bz - cz;
        for (int i = 0; i < kLanes; ++i) {
          const float ex = rho[i] - ax, ez = z[i] - az, gx = rho[i] - bx, gz = z[i] - bz;
          const float vx = rho[i] - cx, vz = z[i] - cz, length = std::sqrt(vx * vx + vz * vz);
          const float on = (length - radius) * (length - radius);
          const float e2 = ex * ex + ez * ez, g2 = gx * gx + gz * gz, ends = e2 < g2 ? e2 : g2;
          const float between = static_cast<float>(static_cast<int>(ux * vz - uz * vx >= 0.0f) &
                                                   static_cast<int>(vx * wz - vz * wx >= 0.0f));
          const float d2 = between > 0.5f ? on : ends;
          best[i] = d2 < best[i] ? d2 : best[i];
          const float outside = static_cast<float>(static_cast<int>(dx * ez - dz * ex < 0.0f) & static_cast<int>(length > radius));
          inside[i] = outside > 0.5f ? -1.0f : inside[i];
        }
      }
    }
    const int lanes = count - start < kLanes ? count - start : kLanes;
    for (int i = 0; i < lanes; ++i) {
      const float d = inside[i] * std::sqrt(best[i]);
      depth[start + i] = d > depth[start + i] ? d : depth[start + i];
    }
  }
}

/// new = max(old, min(depth, kInner)), depths below -kMargin not counted.
int raise_to(float* row, float* before, const float* depth, int count) {
  int changed = 0, volume = 0;
  for (int i = 0; i < count; ++i) {
    const float capped = depth[i] > Sweep::kInner ? Sweep::kInner : depth[i];
    const float counted = capped > -Sweep::kMargin ? capped : -1e9f;
    const float old = row[i], now = counted > old ? counted : old;
    before[i] = old;
    row[i] = now;
    const int differs = static_cast<int>(now > old);
    changed |= differs;
    volume |= differs & static_cast<int>(now > -0.5f) & static_cast<int>(old < 0.5f);
  }
  return changed | volume << 1;
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
  constexpr int kBlock = 4, kDeep = 8;  // a block is kBlock x kBlock x kDeep samples
  bool changed = false;
  float pieces[HeadField::kMaxPieces][10];
  for (int p = 0; p < head_.count; ++p) {
    const HeadField::Piece& piece = head_.pieces[p];
    const double values[10] = {piece.ax, piece.az, piece.bx, piece.bz, piece.dx,
                               piece.dz, piece.inverse2, piece.cx, piece.cz, piece.radius};
    for (int i = 0; i < 10; ++i) pieces[p][i] = static_cast<float>(values[i]);
  }
  // Blocks are aligned to the voxel grid, so that a sample's depth does not depend on how the work was cut up.
  const auto down = [](int v, int step) { return v - (v % step + step) % step; };
  const double half = glm::length(dvec3(kBlock - 1, kBlock - 1, kDeep - 1)) / 2 + 1e-3;
  const int last = poses_;
  const glm::dmat3 R_AV = glm::transpose(glm::dmat3(X_VA_.R)), R_BV = glm::transpose(glm::dmat3(X_VB_.R));
  for (int x0 = down(lo.x, kBlock); x0 < lo.x + size.x; x0 += kBlock) {
    for (int y0 = down(lo.y, kBlock); y0 < lo.y + size.y; y0 += kBlock) {
      for (int z0 = down(lo.z, kDeep); z0 < lo.z + size.z; z0 += kDeep) {
        const dvec3 origin(x0, y0, z0), center = origin + dvec3(kBlock - 1, kBlock - 1, kDeep - 1) / 2.0;
        float depth[kBlock][kBlock][kDeep];
        bool any = false;
        for (int k = continues_ ? 1 : 0; k <= last; ++k) {
          const Pose X_VT = k == 0 ? X_VA_ : k == last ? X_VB_ : pose(k);
          const glm::dmat3 R_TV = k == 0 ? R_AV : k == last ? R_BV : glm::transpose(glm::dmat3(X_VT.R));
          if (head_.distance(R_TV * (center - X_VT.p)) > kMargin + half) continue;
          if (!any) std::fill_n(&depth[0][0][0], kBlock * kBlock * kDeep, -1e9f);
          any = true;
          const glm::vec3 step(R_TV[2]);
          for (int x = 0; x < kBlock; ++x) {
            for (int y = 0; y < kBlock; ++y) {
              const glm::vec3 p(R_TV * (origin + dvec3(x, y, 0) - X_VT.p));
              const Row row{p.x, p.y, p.z, step.x, step.y, step.z};
              deepen_row(depth[x][y], kDeep, &row, pieces, head_.count);
            }
          }
        }
        if (!any) continue;
        const glm::ivec3 from = glm::max(glm::ivec3(x0, y0, z0), lo);
        const glm::ivec3 to = glm::min(glm::ivec3(x0 + kBlock, y0 + kBlock, z0 + kDeep), lo + size);
        float before[kDeep];
        for (int x = from.x; x < to.x; ++x) {
          for (int y = from.y; y < to.y; ++y) {
            const std::size_t at = static_cast<std::size_t>(x - lo.x) * stride_x +
                                   static_cast<std::size_t>(y - lo.y) * stride_y + static_cast<std::size_t>(from.z - lo.z);
            const int count = to.z - from.z;
            const int what = raise_to(distance + at, before, &depth[x - x0][y - y0][from.z - z0], count);
            changed |= what != 0;
            if (removed && (what & 2)) account(before, distance + at, tissue + at, count, *removed);
          }
        }
      }
    }
  }
  return changed;
}

}  // namespace typodont::haptics
