#include "haptics/sweep.h"

#include <algorithm>
#include <cmath>

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

void Sweep::depth_row(int x, int y, int z, int count, float* depth) const noexcept {
  if (!sphere_) return general_row(x, y, z, count, depth);
  const float px = static_cast<float>(x - base_.x) - a_.x;
  const float py = static_cast<float>(y - base_.y) - a_.y;
  const float dot_xy = px * ab_.x + py * ab_.y;
  for (int i = 0; i < count; ++i) {
    const float pz = static_cast<float>(z + i - base_.z) - a_.z;
    float s = (dot_xy + pz * ab_.z) * inverse_length2_;
    s = s < 0.0f ? 0.0f : s;
    s = s > 1.0f ? 1.0f : s;
    const float dx = px - s * ab_.x, dy = py - s * ab_.y, dz = pz - s * ab_.z;
    depth[i] = radius_ - std::sqrt(dx * dx + dy * dy + dz * dz);
  }
}

void Sweep::general_row(int x, int y, int z, int count, float* depth) const noexcept {
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
