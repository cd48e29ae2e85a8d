// The path by which the proxy came, so that it can be led back where its contacts hold it and the hand has left.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::haptics::offset {

/// Points from outside the tissue to where the proxy is now, voxels. What lies between two visits of one place is left
/// out: the path has no loops. Bounded: a full path keeps every second point. Servo thread; allocates at set-up only.
class RetreatPath {
 public:
  RetreatPath() { points_.reserve(kMost); }

  /// The head is outside: the path begins here.
  void begin(const dvec3& c) noexcept {
    points_.clear();
    points_.push_back(c);
    longest_ = kSpacing;
  }
  /// The proxy has come to c.
  void add(const dvec3& c) noexcept;
  std::size_t size() const { return points_.size(); }
  const dvec3& last() const { return points_.back(); }
  void drop_last() noexcept { points_.pop_back(); }
  /// The place of the point that is nearest to `target`; size() where none is nearer than `within`.
  std::size_t nearest(const dvec3& target, double within) const noexcept;

 private:
  static constexpr std::size_t kMost = 512;
  static constexpr double kSpacing = 0.5;    // voxels between two points at least
  static constexpr double kSamePlace = 0.7;  // voxels within which a place was visited before
  static constexpr double kLeap = 8;         // voxels: a proxy that came this far since was moved freely

  std::vector<dvec3> points_;
  double longest_ = kSpacing;  // voxels between two points, at most
};

}  // namespace typodont::haptics::offset
