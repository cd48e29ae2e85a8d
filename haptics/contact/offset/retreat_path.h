// Of the proxy, to lead it back when contacts hold it from the hand.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::haptics::offset {

/// Voxels, from outside to the proxy, without loops; when full, every second goes. Servo thread; allocates at set-up.
class RetreatPath {
 public:
  RetreatPath() { points_.reserve(kMost); }

  /// Outside the tissue.
  void begin(const dvec3& c) noexcept {
    points_.clear();
    points_.push_back(c);
    longest_ = kSpacing;
    far_ = 0;
  }
  /// The proxy's new position.
  void add(const dvec3& c) noexcept;
  std::size_t size() const { return points_.size(); }
  const dvec3& last() const { return points_.back(); }
  void drop_last() noexcept {
    points_.pop_back();
    far_ = std::min(far_, points_.size());
  }
  /// Nearest to `target`; size(): none within `within`.
  std::size_t nearest(const dvec3& target, double within) const noexcept;

 private:
  static constexpr std::size_t kMost = 512;
  static constexpr double kSpacing = 0.5;  // voxels, least between points
  // voxels; nearer is the same place
  static constexpr double kSamePlace = 0.7;
  // voxels; more starts a new path
  static constexpr double kLeap = 8;
  static constexpr double kFar = 8;  // voxels, see far_

  void find_far_points(const dvec3& c) noexcept;

  std::vector<dvec3> points_;
  double longest_ = kSpacing;  // voxels, largest so far
  // Points below far_ are farther than kFar + kSamePlace from far_from_: not met within kFar of it.
  std::size_t far_ = 0;
  dvec3 far_from_{0};
};

}  // namespace typodont::haptics::offset
