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

  /// For voxels (x, y, z .. z+count-1): writes how deep each lies inside the swept head, in voxels, positive inside;
  /// anything below -kMargin may be reported as -1e9.
  void depth_row(int x, int y, int z, int count, float* depth) const noexcept;

  /// Distances are kept true as far as this from the new surface: the reach of the cubic interpolation.
  static constexpr float kMargin = 4.0f;

 private:
  void general_row(int x, int y, int z, int count, float* depth) const noexcept;

  const Tool* tool_;
  bool sphere_;
  glm::ivec3 base_;        // coordinates are taken from here, so that floats keep their digits
  glm::vec3 a_, ab_;       // capsule, in voxels from base_
  float inverse_length2_;  // 1/|ab|², 0 for a point
  float radius_;           // voxels
  int poses_;
  Pose X_VA_, X_VB_;       // general heads: poses in voxels, absolute
  double voxel_;           // m
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
