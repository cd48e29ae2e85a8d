#include "haptics/fill.h"

#include <algorithm>
#include <cmath>

#include "haptics/label.h"
#include "haptics/share.h"
#include "haptics/solid.h"

namespace typodont::haptics {

namespace {

constexpr double kClear = 0.5;      // voxels that stay between head and filling, so that it comes out again without jamming
constexpr float kLabelled = 1;      // voxels outside the new surface that carry its label, so that it can be read there

/// Where on its axis a head is widest, nearest to its free end; m.
double widest_at(const Tool& tool) {
  const double half = tool.length / 2;
  switch (tool.shape) {
    case HeadShape::kSphere: return 0;
    case HeadShape::kRoundEndCylinder:
    case HeadShape::kPear: return -half + tool.radius();
    case HeadShape::kFlame: return -half + tool.length / 3;
    case HeadShape::kCone:
    case HeadShape::kShaft: return half;
    case HeadShape::kCylinder:
    case HeadShape::kInvertedCone: break;
  }
  return -half;
}

}  // namespace

Fill::Fill(const Tool& tool, const dvec3& center_W, double radius, const Pose& X_WT, const VoxelFrame& frame)
    : label_(tool.fill),
      within_(tool.fill_within.get()),
      frame_(frame),
      head_(tool, frame.voxel),
      sphere_(tool.shape == HeadShape::kSphere),
      head_radius_(tool.radius() / frame.voxel),
      widest_at_(widest_at(tool) / frame.voxel),
      center_(frame.to_voxels(center_W)),
      radius_(radius / frame.voxel),
      X_VT_{frame.to_voxels(X_WT.p), X_WT.R},
      R_TV_(glm::transpose(glm::dmat3(X_WT.R))) {
  const dvec3 reach(radius_ + static_cast<double>(Sweep::kMargin));
  lo_ = glm::ivec3(glm::ceil(center_ - reach));
  hi_ = glm::ivec3(glm::floor(center_ + reach));
}

double Fill::kept_out(const dvec3& p) const noexcept {
  const dvec3 q = R_TV_ * (p - X_VT_.p);
  const double to_head = q.z > widest_at_ ? std::hypot(q.x, q.y) - head_radius_
                         : sphere_        ? glm::length(q) - head_radius_
                                          : head_.distance(q);
  const double by_head = kClear - to_head;
  return within_ ? std::max(by_head, within_->distance(frame_.to_world(p)) / frame_.voxel) : by_head;
}

bool Fill::lower(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue, std::size_t stride_x,
                 std::size_t stride_y, PerTissue* added) const noexcept {
  bool changed = false;
  const double inner = -static_cast<double>(Sweep::kInner), margin = static_cast<double>(Sweep::kMargin);
  const double reach = radius_ + margin;
  const auto full = static_cast<float>(inner);  // no ball makes it lower
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      const std::size_t row = static_cast<std::size_t>(x) * stride_x + static_cast<std::size_t>(y) * stride_y;
      // No farther along z than the ball lies, and a little more.
      const dvec3 first = dvec3(lo + glm::ivec3(x, y, 0)) - center_;
      const double chord2 = reach * reach - first.x * first.x - first.y * first.y;
      if (chord2 < 0) continue;
      const double chord = std::sqrt(chord2);
      const int from = std::max(0, static_cast<int>(-first.z - chord)), to = std::min(size.z, static_cast<int>(chord - first.z) + 2);
      for (int z = from; z < to; ++z) {
        const std::size_t i = row + static_cast<std::size_t>(z);
        const float old = distance[i];
        if (old <= full) continue;
        const dvec3 p(lo + glm::ivec3(x, y, z));
        double d = std::max(glm::length(p - center_) - radius_, inner);
        if (d >= margin || static_cast<float>(d) >= old) continue;
        d = std::max(d, kept_out(p));
        const auto now = static_cast<float>(d);
        if (d >= margin || now >= old) continue;
        distance[i] = now;
        changed = true;
        if (old > 0 && now < kLabelled) tissue[i] = filled(tissue[i], label_);
        // All that comes is the filling's, also where it fills up a voxel that stays the wall's, which has one label only.
        if (added) (*added)[static_cast<std::size_t>(label_)] += share_inside(now) - share_inside(old);
      }
    }
  }
  return changed;
}

}  // namespace typodont::haptics
