// The recorded path of the proxy. If the hand has moved away but contacts hold the proxy, the proxy is led back along
// this path.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::haptics::offset {

/// Path points in voxels, from outside the tissue to the proxy's position. Loops are removed: when the path returns to
/// a place, the points since the first visit are dropped. When the memory is full, every second point is dropped. Servo
/// thread; allocates memory at set-up only.
class RetreatPath {
 public:
  RetreatPath() { points_.reserve(kMost); }

  /// Starts the path at position c, which is outside the tissue.
  void begin(const dvec3& c) noexcept {
    points_.clear();
    points_.push_back(c);
    longest_ = kSpacing;
    far_ = 0;
  }
  /// Adds the proxy's new position c to the path.
  void add(const dvec3& c) noexcept;
  std::size_t size() const { return points_.size(); }
  const dvec3& last() const { return points_.back(); }
  void drop_last() noexcept {
    points_.pop_back();
    far_ = std::min(far_, points_.size());
  }
  /// Returns the index of the path point nearest to `target`, or size() if all points are farther away than `within`.
  std::size_t nearest(const dvec3& target, double within) const noexcept;

 private:
  static constexpr std::size_t kMost = 512;
  static constexpr double kSpacing = 0.5;  // voxels, smallest distance between two successive points of the path
  // voxels; two points nearer to each other than this count as the same place
  static constexpr double kSamePlace = 0.7;
  // voxels; if the distance between two successive points is larger than this, a new path starts
  static constexpr double kLeap = 8;
  static constexpr double kFar = 8;  // voxels, see far_

  void find_far_points(const dvec3& c) noexcept;

  std::vector<dvec3> points_;
  double longest_ = kSpacing;  // voxels, largest distance between two successive points of the path
  // The points with an index below far_ are farther than kFar + kSamePlace from the position far_from_. As long as the
  // proxy is nearer than kFar to this position, it is not at the same place as any of these points.
  std::size_t far_ = 0;
  dvec3 far_from_{0};
};

}  // namespace typodont::haptics::offset
