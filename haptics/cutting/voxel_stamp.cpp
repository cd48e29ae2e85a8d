#include "haptics/cutting/voxel_stamp.h"

#include "haptics/cutting/inside_fraction.h"
#include "haptics/volume/label.h"

namespace typodont::haptics {

namespace {

constexpr float kCleared = 0.5f;  // voxels, value of a removed voxel's sample: the voxel is completely air

}  // namespace

VoxelStamp::VoxelStamp(const Tool& tool, const Pose& X_WT, const VoxelFrame& frame)
    : head_(tool, frame.voxel), X_TV_(inverse(Pose{frame.to_voxels(X_WT.p), X_WT.R})) {
  const dvec3 center = frame.to_voxels(X_WT.p);
  const double reach = tool.reach() / frame.voxel;
  lo_ = glm::ivec3(glm::ceil(center - reach));
  hi_ = glm::ivec3(glm::floor(center + reach));
}

bool VoxelStamp::carve(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x,
                       std::size_t stride_y, const Tissue* tissue, RemovedVolume* removed) const noexcept {
  bool changed = false;
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      const std::size_t row = static_cast<std::size_t>(x) * stride_x + static_cast<std::size_t>(y) * stride_y;
      for (int z = 0; z < size.z; ++z) {
        float& d = distance[row + static_cast<std::size_t>(z)];
        if (d >= kCleared || head_.distance(X_TV_ * dvec3(lo + glm::ivec3(x, y, z))) > 0) continue;
        if (removed) {
          removed->add(inside_units(d), shown(tissue[row + static_cast<std::size_t>(z)]), &d);
        }
        d = kCleared;
        changed = true;
      }
    }
  }
  return changed;
}

}  // namespace typodont::haptics
