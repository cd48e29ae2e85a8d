// Removal of whole voxels: every voxel whose centre lies in the head becomes air. The yardstick beside Sweep.
#pragma once

#include <cstddef>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// What a head at one pose takes. Servo's patch and carver's volume both use carve(), so that they hold the same bits.
class VoxelStamp {
 public:
  VoxelStamp(const Tool& tool, const Pose& X_WT, const VoxelFrame& frame);

  /// Voxels, inclusive, around the head.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Clears a block of voxels, lo .. lo+size-1, z fastest; strides in samples. Adds to `removed`, where given, the
  /// volume per tissue in voxels³. Returns whether any voxel changed. Any thread.
  bool carve(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x, std::size_t stride_y,
             const Tissue* tissue, PerTissue* removed) const noexcept;

 private:
  HeadField head_;  // voxels
  Pose X_TV_;       // voxels
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
