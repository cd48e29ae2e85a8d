// What a filling instrument puts down in one tick, as a distance on voxels: the counterpart of Sweep. The servo's patch
// and the carver's volume both fill with exactly this function, so that they hold the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "haptics/sweep.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// Which voxels of air were given a label, by their place in a block: as many as one tick of filling labels anew, and
/// more.
class FreshLabels {
 public:
  void add(std::ptrdiff_t at) noexcept {
    if (count_ < kMost) at_[count_] = static_cast<std::int32_t>(at);
    ++count_;
  }
  /// False when there were more than are known.
  bool all() const noexcept { return count_ <= kMost; }
  std::span<const std::int32_t> known() const noexcept {
    return {at_, static_cast<std::size_t>(count_ < kMost ? count_ : kMost)};
  }

 private:
  static constexpr int kMost = 4096;
  std::int32_t at_[kMost];
  int count_ = 0;
};

/// A ball of filling, inside the tool's limit where it has one, but for the head that presses it and for the head's way
/// out along its axis: it grows to half a voxel from these and no farther, so that it neither pushes nor holds the
/// hand.
class Fill {
 public:
  Fill(const Tool& tool, const dvec3& center_W, double radius, const Pose& X_WT, const VoxelFrame& frame);

  /// Voxels, inclusive, that lie within Sweep::kMargin voxels of the ball.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Lowers the distances of a block of voxels, lo .. lo+size-1, to that from the filling (at least -Sweep::kInner),
  /// wherever that is less, and labels what was empty (label.h); tells `fresh`, where given, which of the voxels of air
  /// are labelled anew. z runs fastest; the strides are in samples. Adds to `added`, where given, the volume per tissue
  /// in voxels³. Returns whether any sample changed. Any thread; the same bits whatever the processor and the block.
  bool lower(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue, std::size_t stride_x,
             std::size_t stride_y, PerTissue* added, FreshLabels* fresh = nullptr) const noexcept;

  /// How far p lies outside of where head and way out let filling lie, and of where the tool's limit does, if it has
  /// one; voxels, negative inside.
  double kept_by_head(const dvec3& p) const noexcept;
  double beyond_limit(const dvec3& p) const noexcept;
  bool is_limited() const noexcept { return within_ != nullptr; }

  static constexpr float kClear =
      0.5f;  // voxels that stay between head and filling, so that it comes out again without jamming

 private:
  Tissue label_;
  const Solid* within_;  // the tool's, or none
  VoxelFrame frame_;
  HeadField head_;  // with its way out, voxels
  dvec3 center_;    // voxels
  double radius_;
  Pose X_VT_;  // of the head, voxels
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
