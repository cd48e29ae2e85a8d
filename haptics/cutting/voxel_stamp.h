// Removes whole voxels: every voxel whose centre lies in the head becomes air. Used as a reference, with which cuts by
// Sweep are compared.
#pragma once

#include <cstddef>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "haptics/cutting/removed.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// The voxels that a head removes at one pose. The servo's patch and the carver's volume both use carve(), so that
/// they contain the same bits.
class VoxelStamp {
 public:
  VoxelStamp(const Tool& tool, const Pose& X_WT, const VoxelFrame& frame);

  /// First and last voxel of the box of voxels around the head.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Clears a block of voxels: those whose centres lie in the head become air. `lo`, `size`: first voxel and number of
  /// voxels along each axis; z is the fastest index, strides in samples. If `removed` is given, adds to it the removed
  /// volume per tissue in voxels³. Returns true if any voxel changed. Any thread.
  bool carve(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x, std::size_t stride_y,
             const Tissue* tissue, RemovedVolume* removed) const noexcept;

 private:
  HeadField head_;  // lengths in voxels
  Pose X_TV_;       // pose of the voxel frame V in the head's frame T; positions in voxels
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
