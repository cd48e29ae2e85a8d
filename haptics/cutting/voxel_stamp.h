// Removes all voxels whose centres are in the head: reference with which Sweep is compared.
#pragma once

#include <cstddef>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "haptics/cutting/removed.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// A head at one pose. Tissue patch and volume both use carve(), so they remain bit-identical.
class VoxelStamp {
 public:
  VoxelStamp(const Tool& tool, const Pose& X_WT, const VoxelFrame& frame);

  /// Box of voxels around the head.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// `lo`, `size`: box in voxels; z is the fastest index, strides in samples. `removed`: voxels³ of each tissue.
  /// Returns true if a sample changed. Any thread.
  bool carve(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x, std::size_t stride_y,
             const Tissue* tissue, RemovedVolume* removed) const noexcept;

 private:
  HeadField head_;  // lengths in voxels
  Pose X_TV_;       // pose of the volume's frame V in the tool's frame T, voxels
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
