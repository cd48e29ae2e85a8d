// Filling added in one tick, as a distance field (Sweep is its counterpart for removal). Servo and carver use the same
// code, so the tissue patch and the tissue stay bit-identical.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "haptics/sweep.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// Samples in air that got the filling's label in one tick, as indices in the processed block of samples.
class FreshLabels {
 public:
  void add(std::ptrdiff_t at) noexcept {
    if (count_ < kMost) at_[count_] = static_cast<std::int32_t>(at);
    ++count_;
  }
  /// Returns false if more than kMost samples got a label, so that the list is incomplete.
  bool all() const noexcept { return count_ <= kMost; }
  std::span<const std::int32_t> known() const noexcept {
    return {at_, static_cast<std::size_t>(count_ < kMost ? count_ : kMost)};
  }

 private:
  static constexpr int kMost = 4096;
  std::int32_t at_[kMost];
  int count_ = 0;
};

/// A ball of filling, minus the head that presses it, and minus the head's exit path along its axis. Head and path are
/// enlarged by half a voxel (kClear), so that the filling exerts no force. Filling outside a limiting solid is omitted.
class Fill {
 public:
  Fill(const Tool& tool, const dvec3& center_W, double radius, const Pose& X_WT, const VoxelFrame& frame);

  /// First and last voxel (inclusive) of the box within Sweep::kMargin of the ball.
  const glm::ivec3& lo() const { return lo_; }
  const glm::ivec3& hi() const { return hi_; }

  /// Adds the filling to samples lo to lo+size-1 (z runs fastest; strides in samples): a sample becomes
  /// min(sample, max(filling's distance, -Sweep::kInner)). Empty voxels get a label (label.h). `added`: volume per
  /// tissue, voxels³; `fresh`: air samples that got a label; both may be null. Returns true if a sample changed. Any
  /// thread. Equal bits on every processor, and if the volume is filled in several calls with smaller boxes.
  bool lower(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue, std::size_t stride_x,
             std::size_t stride_y, PerTissue* added, FreshLabels* fresh = nullptr) const noexcept;

  /// Filling is allowed where both functions are below 0. kept_by_head(): depth of p in the head and its exit path,
  /// plus a clearance; beyond_limit(): distance of p outside the solid that limits the filling. Voxels.
  double kept_by_head(const dvec3& p) const noexcept;
  double beyond_limit(const dvec3& p) const noexcept;
  bool is_limited() const noexcept { return within_ != nullptr; }

  static constexpr float kClear = 0.5f;  // voxels, clearance between head and filling

 private:
  Tissue label_;
  const Solid* within_;  // solid that limits the filling; null: no limit
  VoxelFrame frame_;
  HeadField head_;  // head together with its exit path along the axis; lengths in voxels
  dvec3 center_;    // voxels, centre of the ball of filling
  double radius_;
  Pose X_VT_;  // pose of the head in the volume's frame V, voxels
  glm::ivec3 lo_, hi_;
};

}  // namespace typodont::haptics
