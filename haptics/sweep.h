// The space a head sweeps in one tick, as a distance on voxels. The servo's patch and the carver's volume both cut with
// exactly this function, so that they hold the same bits.
#pragma once

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// A head moved from A to B: of a sphere the exact capsule, of any other head the union of poses close enough together
/// that the scallops between them stay under 1/100 voxel.
class Sweep {
 public:
  Sweep(const Tool& tool, const Pose& X_WA, const Pose& X_WB, const VoxelFrame& frame);

  /// Voxels, inclusive, that lie within `kMargin` voxels of the swept head.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Raises the distances of a block of voxels, lo .. lo+size-1, to how deep each lies in the swept head, wherever that
  /// is more: takes material away. z runs fastest; the strides are in samples. Adds to `removed`, where given, the volume
  /// taken per tissue in voxels³ (the share of each voxel inside the surface before, less after). Returns whether any
  /// sample changed. Any thread; the same bits whatever the processor.
  bool raise(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x, std::size_t stride_y,
             const Tissue* tissue, PerTissue* removed) const noexcept;

  /// Distances are kept true as far as this from the new surface: the reach of the cubic interpolation.
  static constexpr float kMargin = 4.0f;

 private:
  void depth_row(int x, int y, int z, int count, float* depth) const noexcept;

  const Tool* tool_;
  bool sphere_;
  glm::ivec3 base_;        // coordinates are taken from here, so that floats keep their digits
  glm::vec3 a_, ab_;       // capsule, in voxels from base_
  float inverse_length2_;  // 1/|ab|², 0 for a point
  float radius_;           // voxels
  float row_reach_;        // voxels from the middle of the sweep to where it still changes anything
  int poses_;
  Pose X_VA_, X_VB_;       // general heads: poses in voxels, absolute
  double voxel_;           // m
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
