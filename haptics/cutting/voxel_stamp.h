// Voxels whose centres are in the head become air: a reference for Sweep.
#pragma once

#include <cstddef>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "haptics/cutting/removed.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// At one pose. Patch and volume use carve(), so bits agree.
class VoxelStamp {
 public:
  VoxelStamp(const Tool& tool, const Pose& X_WT, const VoxelFrame& frame);

  /// Around the head.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// `lo`, `size`: voxels; z fastest, strides in samples. `removed`: voxels³ per tissue. True: changed. Any thread.
  bool carve(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x, std::size_t stride_y,
             const Tissue* tissue, RemovedVolume* removed) const noexcept;

 private:
  HeadField head_;  // lengths in voxels
  Pose X_TV_;       // V in T; voxels
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
