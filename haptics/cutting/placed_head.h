// Adds a tool's head as tissue, such as an implant.
#pragma once

#include <cstddef>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "haptics/fill.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// Fills the shape of a tool's head with tissue; for implants that stay in bone. Carver thread only.
class PlacedHead {
 public:
  PlacedHead(const Tool& tool, Tissue label, const Pose& X_WT, const VoxelFrame& frame);

  /// Box of voxels within Sweep::kMargin (3.5 voxels) of the head.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Lowers each sample to its distance from the head, if this is smaller; see Fill::lower().
  bool lower(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue, std::size_t stride_x,
             std::size_t stride_y, PerTissue* added) const noexcept;

 private:
  HeadField head_;  // lengths in voxels
  Tissue label_;
  Pose X_TV_;  // pose of the volume's frame V in the tool's frame T, voxels
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
