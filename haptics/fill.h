// The filling that an instrument adds in one tick, as a distance field. (For a removal of tissue, the class Sweep has
// this purpose.) The servo (in its copy of the tissue) and the carver (owner of the tissue) both use this class, so
// that copy and tissue stay equal bit by bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "haptics/sweep.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// List of the voxels that were air and got a label in one tick of filling. A voxel is stored as an index within its
/// block.
class FreshLabels {
 public:
  void add(std::ptrdiff_t at) noexcept {
    if (count_ < kMost) at_[count_] = static_cast<std::int32_t>(at);
    ++count_;
  }
  /// Returns false if the list is incomplete, because more than kMost voxels were added.
  bool all() const noexcept { return count_ <= kMost; }
  std::span<const std::int32_t> known() const noexcept {
    return {at_, static_cast<std::size_t>(count_ < kMost ? count_ : kMost)};
  }

 private:
  static constexpr int kMost = 4096;
  std::int32_t at_[kMost];
  int count_ = 0;
};

/// The shape of the filling that is added in one tick: a ball, from which two shapes are subtracted. One is the head
/// that presses the filling. The other is the head's exit path along the tool's axis. The filling keeps a clearance of
/// half a voxel (kClear) from both, so that it exerts no force on the hand. If a solid limits the tool's filling, only
/// the part inside this solid is added.
class Fill {
 public:
  Fill(const Tool& tool, const dvec3& center_W, double radius, const Pose& X_WT, const VoxelFrame& frame);

  /// Corners of the box (inclusive) that contains all voxels within Sweep::kMargin voxels of the ball.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Adds the filling to a block of voxels from lo to lo+size-1. Where the distance to the filling (at least
  /// -Sweep::kInner) is smaller than the stored distance, it replaces the stored distance. Empty voxels get a label
  /// (label.h). z runs fastest; the strides are in samples. `added` (may be null): voxels³, added volume per tissue.
  /// `fresh` (may be null): voxels of air that got a label. Returns true if any sample changed. Any thread; the result
  /// has the same bits for every processor and every division into blocks.
  bool lower(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue, std::size_t stride_x,
             std::size_t stride_y, PerTissue* added, FreshLabels* fresh = nullptr) const noexcept;

  /// Filling is allowed only outside the head and outside the head's exit path. kept_by_head(): voxels, signed distance
  /// from p to this allowed region, negative inside it. beyond_limit(): voxels, signed distance from p to the solid
  /// that limits the filling (if there is one), negative inside it.
  double kept_by_head(const dvec3& p) const noexcept;
  double beyond_limit(const dvec3& p) const noexcept;
  bool is_limited() const noexcept { return within_ != nullptr; }

  static constexpr float kClear = 0.5f;  // voxels, clearance between head and filling

 private:
  Tissue label_;
  const Solid* within_;  // solid that limits the filling; null: no limit
  VoxelFrame frame_;
  HeadField head_;  // voxels, distance field of the head and of the cylinder along which it can leave (exit path)
  dvec3 center_;    // voxels, centre of the ball of filling
  double radius_;
  Pose X_VT_;  // pose of the head in the frame V of the voxel grid, in voxels
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
