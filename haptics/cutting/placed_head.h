// Adds a body with the shape of a tool's head to the tissue, for example an implant.
#pragma once

#include <cstddef>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "haptics/fill.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// Adds the shape of a tool's head at one pose to the tissue, as Fill adds a ball. It is used for an implant that stays
/// in the bone. Carver thread only.
class PlacedHead {
 public:
  PlacedHead(const Tool& tool, Tissue label, const Pose& X_WT, const VoxelFrame& frame);

  /// First and last voxel of the box that contains all voxels within Sweep::kMargin (3.5) voxels of the head.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Adds the body to a block of samples: reduces each distance to the distance from the body, if this is smaller than
  /// the old one. Fill::lower() explains the arguments.
  bool lower(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue, std::size_t stride_x,
             std::size_t stride_y, PerTissue* added) const noexcept;

 private:
  HeadField head_;  // lengths in voxels
  Tissue label_;
  Pose X_TV_;  // pose of the voxel frame V in the head's frame T; positions in voxels
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
