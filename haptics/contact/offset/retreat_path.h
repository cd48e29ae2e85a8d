// The recorded path of the proxy. A proxy that its contacts hold is led back along it when the hand has left.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::haptics::offset {

/// Points in voxels, from outside the tissue to the proxy's position. Loops are removed: points between two visits of
/// the same place are dropped. A full path drops every second point. Servo thread; allocates at set-up only.
class RetreatPath {
 public:
  RetreatPath() { points_.reserve(kMost); }

  /// Starts the path at c, outside the tissue.
  void begin(const dvec3& c) noexcept {
    points_.clear();
    points_.push_back(c);
    longest_ = kSpacing;
  }
  /// Adds the proxy's new position c.
  void add(const dvec3& c) noexcept;
  std::size_t size() const { return points_.size(); }
  const dvec3& last() const { return points_.back(); }
  void drop_last() noexcept { points_.pop_back(); }
  /// Index of the point nearest to `target`; size() if none is nearer than `within`.
  std::size_t nearest(const dvec3& target, double within) const noexcept;

 private:
  static constexpr std::size_t kMost = 512;
  static constexpr double kSpacing = 0.5;    // voxels, smallest distance between two points
  static constexpr double kSamePlace = 0.7;  // voxels, distance below which two points are the same place
  static constexpr double kLeap = 8;         // voxels, distance from the last point above which the path starts anew

  std::vector<dvec3> points_;
  double longest_ = kSpacing;  // voxels, largest distance between two points
};

}  // namespace typodont::haptics::offset
