// The recorded path of the proxy, along which it moves back when contacts hold it away from the hand.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// Path of the proxy: points (voxels) from outside the tissue to the proxy, without loops. If the memory is full, every
/// second point is removed. Servo thread only; allocates at set-up.
class RetreatPath {
 public:
  /// True if a head with orientation `now` does not fit the hole that it cut with orientation `then`. Not for balls.
  static bool turned(const dquat& now, const dquat& then) noexcept {
    constexpr double kSameTurn = 1e-4;  // 1 - |cos(half the angle between the orientations)|
    return 1 - std::abs(glm::dot(now, then)) > kSameTurn;
  }

  RetreatPath() { points_.reserve(kMost); }

  /// Starts a new path at c, outside the tissue.
  void begin(const dvec3& c) noexcept {
    points_.clear();
    points_.push_back(c);
    longest_ = kSpacing;
    far_ = 0;
  }
  /// Adds the proxy's new position.
  void add(const dvec3& c) noexcept;
  std::size_t size() const { return points_.size(); }
  const dvec3& last() const { return points_.back(); }
  void drop_last() noexcept {
    points_.pop_back();
    far_ = std::min(far_, points_.size());
  }
  /// Returns c, moved back along the path by at most `max_step`, as far as the path leads towards `target`. Needed in
  /// a deep hole: inexact contacts can hold the head although its path is free of tissue.
  dvec3 withdrawn(dvec3 c, const dvec3& target, double max_step) noexcept;
  /// Index of the point nearest to `target`, or size() if none is nearer than `within`.
  std::size_t nearest(const dvec3& target, double within) const noexcept;

 private:
  static constexpr std::size_t kMost = 512;
  static constexpr double kSpacing = 0.5;  // voxels, smallest distance between consecutive points of the path
  // smallest cosine between the path back and the direction to the hand for which the proxy moves back
  static constexpr double kTowards = 0.3;
  // voxels; points nearer to each other count as the same point
  static constexpr double kSamePlace = 0.7;
  // voxels; if the proxy is farther than this from the last point, a new path starts
  static constexpr double kLeap = 8;
  static constexpr double kFar = 8;  // voxels, distance of the proxy from far_from_ up to which far_ is valid

  void find_far_points(const dvec3& c) noexcept;

  std::vector<dvec3> points_;
  double longest_ = kSpacing;  // voxels, largest distance between consecutive points
  // Number of points at the start of the path that a search may skip while the proxy is within kFar of far_from_: these
  // points are farther than kFar + kSamePlace from far_from_.
  std::size_t far_ = 0;
  dvec3 far_from_{0};
};

}  // namespace typodont::haptics
