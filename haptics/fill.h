// What a filling instrument puts down in one tick, as a distance on voxels: the counterpart of Sweep. The servo's patch
// and the carver's volume both fill with exactly this function, so that they hold the same bits.
#pragma once

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "haptics/sweep.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// A ball of filling, inside the tool's limit where it has one, but for the head that presses it and for the head's way out along
/// its axis: it grows to half a voxel from these and no farther, so that it neither pushes nor holds the hand.
class Fill {
 public:
  Fill(const Tool& tool, const dvec3& center_W, double radius, const Pose& X_WT, const VoxelFrame& frame);

  /// Voxels, inclusive, that lie within Sweep::kMargin voxels of the ball.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Lowers the distances of a block of voxels, lo .. lo+size-1, to that from the filling (at least -Sweep::kInner),
  /// wherever that is less, and labels what was empty (label.h). z runs fastest; the strides are in samples. Adds to `added`, where
  /// given, the volume per tissue in voxels³. Returns whether any sample changed. Any thread.
  bool lower(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue, std::size_t stride_x,
             std::size_t stride_y, PerTissue* added) const noexcept;

  /// How far p (voxels) lies outside of where head, its way out and the tool's limit let filling lie, in voxels; negative inside.
  double kept_out(const dvec3& p) const noexcept;

 private:
  Tissue label_;
  const Solid* within_;  // the tool's, or none
  VoxelFrame frame_;
  HeadField head_;       // voxels
  bool sphere_;
  double head_radius_;   // voxels
  double widest_at_;     // voxels along the head's axis
  dvec3 center_;         // voxels
  double radius_;
  Pose X_VT_;            // of the head, voxels
  glm::dmat3 R_TV_;
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
