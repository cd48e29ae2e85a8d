#include "haptics/sweep.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace typodont::haptics {

Sweep::Sweep(const Tool& tool, const Pose& X_WA, const Pose& X_WB, const VoxelFrame& frame)
    : tool_(&tool), sphere_(tool.shape == HeadShape::kSphere), voxel_(frame.voxel) {
  const dvec3 a = frame.to_voxels(X_WA.p), b = frame.to_voxels(X_WB.p);
  base_ = glm::ivec3(glm::floor(a));
  a_ = glm::vec3(a - dvec3(base_));
  ab_ = glm::vec3(b - a);
  const float length2 = glm::dot(ab_, ab_);
  inverse_length2_ = length2 > 1e-12f ? 1 / length2 : 0;
  radius_ = static_cast<float>(tool.radius() / frame.voxel);
  row_reach_ = static_cast<float>(tool.reach() / frame.voxel) + kMargin + 0.5f * std::sqrt(length2);
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

namespace {

constexpr int kRow = 256;  // samples looked at together

/// new = max(old, depth) for a capsule; depth below -kMargin never counts. Written so that it vectorises; FMA is off for
/// the whole program, so every processor computes the same bits.
__attribute__((target_clones("avx2", "default"))) void raise_row(const float* old, float* raised, int count, float px,
                                                                 float py, int first_z, float az, const float* ab,
                                                                 float inverse_length2, float radius) {
  const float dot_xy = px * ab[0] + py * ab[1];
  for (int i = 0; i < count; ++i) {
    const float z = static_cast<float>(first_z + i) - az;  // the same rounding wherever the row starts
    float s = (dot_xy + z * ab[2]) * inverse_length2;
    s = s < 0.0f ? 0.0f : s;
    s = s > 1.0f ? 1.0f : s;
    const float dx = px - s * ab[0], dy = py - s * ab[1], dz = z - s * ab[2];
    const float depth = radius - std::sqrt(dx * dx + dy * dy + dz * dz);
    const float counted = depth > -Sweep::kMargin ? depth : -1e9f;
    raised[i] = counted > old[i] ? counted : old[i];
  }
}

/// Share of a voxel inside a surface that passes `distance` voxels from its centre.
float share_inside(float distance) { return std::clamp(0.5f - distance, 0.0f, 1.0f); }

}  // namespace

bool Sweep::raise(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                  std::size_t stride_y, const Tissue* tissue, PerTissue* removed) const noexcept {
  bool changed = false;
  float raised[kRow];
  const glm::vec3 middle = glm::vec3(base_) + a_ + 0.5f * ab_;
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      // The part of the row that can change: inside the ball around the sweep.
      const float mx = static_cast<float>(lo.x + x) - middle.x, my = static_cast<float>(lo.y + y) - middle.y;
      const float reach2 = row_reach_ * row_reach_ - mx * mx - my * my;
      if (reach2 < 0) continue;
      const float reach = std::sqrt(reach2);
      const int z0 = std::max(0, static_cast<int>(std::ceil(middle.z - reach)) - lo.z);
      const int z1 = std::min(size.z, static_cast<int>(std::floor(middle.z + reach)) - lo.z + 1);
      for (int start = z0; start < z1; start += kRow) {
        const int count = std::min(kRow, z1 - start);
        const std::size_t at = static_cast<std::size_t>(x) * stride_x + static_cast<std::size_t>(y) * stride_y +
                               static_cast<std::size_t>(start);
        float* row = distance + at;
        if (sphere_) {
          raise_row(row, raised, count, static_cast<float>(lo.x + x - base_.x) - a_.x,
                    static_cast<float>(lo.y + y - base_.y) - a_.y, lo.z + start - base_.z, a_.z, &ab_.x, inverse_length2_, radius_);
        } else {
          depth_row(lo.x + x, lo.y + y, lo.z + start, count, raised);
          for (int i = 0; i < count; ++i) raised[i] = raised[i] > -kMargin ? std::max(raised[i], row[i]) : row[i];
        }
        if (std::memcmp(row, raised, static_cast<std::size_t>(count) * sizeof(float)) == 0) continue;
        changed = true;
        if (removed) {
          for (int i = 0; i < count; ++i) {
            if (raised[i] <= -0.5f || row[i] >= 0.5f || raised[i] == row[i]) continue;
            (*removed)[static_cast<std::size_t>(tissue[at + static_cast<std::size_t>(i)])] +=
                static_cast<double>(share_inside(row[i]) - share_inside(raised[i]));
          }
        }
        std::memcpy(row, raised, static_cast<std::size_t>(count) * sizeof(float));
      }
    }
  }
  return changed;
}

void Sweep::depth_row(int x, int y, int z, int count, float* depth) const noexcept {
  for (int i = 0; i < count; ++i) {
    double best = 1e300;
    for (int k = 0; k <= poses_; ++k) {
      const Pose X_VT = interpolate(X_VA_, X_VB_, static_cast<double>(k) / poses_);
      const dvec3 p_TQ = glm::conjugate(X_VT.R) * (dvec3(x, y, z + i) - X_VT.p) * voxel_;
      best = std::min(best, tool_->distance(p_TQ));
    }
    depth[i] = static_cast<float>(-best / voxel_);
  }
}

}  // namespace typodont::haptics
