#include "haptics/cutting/placed_head.h"

#include <algorithm>

#include "engine/base/voxels.h"
#include "haptics/cutting/inside_fraction.h"
#include "haptics/volume/label.h"

namespace typodont::haptics {

namespace {

// voxels; air nearer than this to the placed head also gets its label, so that queries at the surface find the label
constexpr float kLabelled = 1;

}  // namespace

PlacedHead::PlacedHead(const Tool& tool, Tissue label, const Pose& X_WT, const VoxelFrame& frame)
    : head_(tool, frame.voxel), label_(label), X_TV_(inverse(Pose{frame.to_voxels(X_WT.p), X_WT.R})) {
  const dvec3 center = frame.to_voxels(X_WT.p);
  const double reach = tool.reach() / frame.voxel + static_cast<double>(Sweep::kMargin);
  lo_ = glm::ivec3(glm::ceil(center - reach));
  hi_ = glm::ivec3(glm::floor(center + reach));
}

bool PlacedHead::lower(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue,
                       std::size_t stride_x, std::size_t stride_y, PerTissue* added) const noexcept {
  bool changed = false;
  for_each_voxel(size, [&](int x, int y, int z) {
    const std::size_t at =
        static_cast<std::size_t>(x) * stride_x + static_cast<std::size_t>(y) * stride_y + static_cast<std::size_t>(z);
    const float before = distance[at];
    const auto depth = static_cast<float>(head_.distance(X_TV_ * dvec3(lo + glm::ivec3(x, y, z))));
    const float now = std::max(depth, -Sweep::kInner);
    if (!(now < before && now < Sweep::kMargin)) return;
    changed = true;
    distance[at] = now;
    if (added) (*added)[static_cast<std::size_t>(label_)] += fraction_inside(now) - fraction_inside(before);
    if (before > 0 && now < kLabelled) tissue[at] = filled(tissue[at], label_);
  });
  return changed;
}

}  // namespace typodont::haptics
