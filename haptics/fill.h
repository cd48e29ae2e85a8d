// The filling that an instrument adds in one tick, as a distance field: the counterpart of Sweep. The servo's patch and
// the carver's volume both fill with this function, so they contain the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "haptics/sweep.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// Indices (within a block) of the air voxels that received a label in one tick of filling.
class FreshLabels {
 public:
  void add(std::ptrdiff_t at) noexcept {
    if (count_ < kMost) at_[count_] = static_cast<std::int32_t>(at);
    ++count_;
  }
  /// False if there were more such voxels than this list can store.
  bool all() const noexcept { return count_ <= kMost; }
  std::span<const std::int32_t> known() const noexcept {
    return {at_, static_cast<std::size_t>(count_ < kMost ? count_ : kMost)};
  }

 private:
  static constexpr int kMost = 4096;
  std::int32_t at_[kMost];
  int count_ = 0;
};

/// A ball of filling, minus the head that presses it and minus the head's exit path along its axis, and only inside the
/// tool's limit if it has one. The filling keeps half a voxel of clearance (kClear) from head and exit path, so it
/// neither pushes nor holds the hand.
class Fill {
 public:
  Fill(const Tool& tool, const dvec3& center_W, double radius, const Pose& X_WT, const VoxelFrame& frame);

  /// Box of voxels, inclusive, that contains all voxels within Sweep::kMargin voxels of the ball.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Lowers the distances of a block of voxels, lo .. lo+size-1, to the distance to the filling (at least
  /// -Sweep::kInner), wherever this is less, and labels the voxels that were empty (label.h). z runs fastest; the
  /// strides are in samples. `added`, if given, receives the added volume per tissue in voxels³; `fresh`, if given, the
  /// voxels of air with a new label. Returns whether any sample changed. Any thread; the bits depend neither on the
  /// processor nor on the block.
  bool lower(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue, std::size_t stride_x,
             std::size_t stride_y, PerTissue* added, FreshLabels* fresh = nullptr) const noexcept;

  /// Distance from p to the region that the head and its exit path leave for filling; also to the tool's limit, if
  /// is_limited(). Voxels, negative inside the region.
  double kept_by_head(const dvec3& p) const noexcept;
  double beyond_limit(const dvec3& p) const noexcept;
  bool is_limited() const noexcept { return within_ != nullptr; }

  static constexpr float kClear =
      0.5f;  // voxels, clearance between head and filling, so that the head does not jam when it is withdrawn

 private:
  Tissue label_;
  const Solid* within_;  // limit of the tool; null: none
  VoxelFrame frame_;
  HeadField head_;  // head with its exit path, voxels
  dvec3 center_;    // voxels
  double radius_;
  Pose X_VT_;  // pose of the head, voxels
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
