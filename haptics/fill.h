// One tick's filling as a distance field (removal: Sweep). Servo and carver use it alike, so copy and tissue stay equal
// to the bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "haptics/sweep.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// Air that got a label in one tick, by index in the block.
class FreshLabels {
 public:
  void add(std::ptrdiff_t at) noexcept {
    if (count_ < kMost) at_[count_] = static_cast<std::int32_t>(at);
    ++count_;
  }
  /// False: more than kMost, incomplete.
  bool all() const noexcept { return count_ <= kMost; }
  std::span<const std::int32_t> known() const noexcept {
    return {at_, static_cast<std::size_t>(count_ < kMost ? count_ : kMost)};
  }

 private:
  static constexpr int kMost = 4096;
  std::int32_t at_[kMost];
  int count_ = 0;
};

/// A ball without the pressing head and its way out along the axis, each with half a voxel (kClear), so that filling
/// exerts no force. A limiting solid keeps only what is inside.
class Fill {
 public:
  Fill(const Tool& tool, const dvec3& center_W, double radius, const Pose& X_WT, const VoxelFrame& frame);

  /// Inclusive; voxels within Sweep::kMargin of the ball.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Voxels lo to lo+size-1: distance (at least -Sweep::kInner) where smaller; empty voxels get a label (label.h). z
  /// fastest; strides in samples. `added` (may be null): voxels³ per tissue; `fresh` (may be null): labelled air. True:
  /// a sample changed. Any thread; same bits on every processor and in any blocks.
  bool lower(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue, std::size_t stride_x,
             std::size_t stride_y, PerTissue* added, FreshLabels* fresh = nullptr) const noexcept;

  /// Voxels from p to where filling is allowed (outside head and way out), and to the limiting solid; negative inside.
  double kept_by_head(const dvec3& p) const noexcept;
  double beyond_limit(const dvec3& p) const noexcept;
  bool is_limited() const noexcept { return within_ != nullptr; }

  static constexpr float kClear = 0.5f;  // voxels, clearance between head and filling

 private:
  Tissue label_;
  const Solid* within_;  // solid that limits the filling; null: no limit
  VoxelFrame frame_;
  HeadField head_;  // voxels, head and its way out
  dvec3 center_;    // voxels, centre of the ball of filling
  double radius_;
  Pose X_VT_;  // of the head in V, voxels
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
