// The way back of a proxy that contacts hold away from the hand: along its recorded path.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// If the hand has moved away but contacts hold the proxy, the proxy is led back along its recorded path.
struct RetreatParameters {
  // m, distance from hand to proxy above which the hand may have moved away
  static constexpr double far = 2e-3;
  static constexpr double still = 0.3e-3;  // m; a proxy that moves less counts as held by contacts
  // m, distance from hand to proxy above which the hand has surely moved away: nobody presses with 5 N (at 1 N/mm)
  static constexpr double too_far = 5e-3;
  static constexpr double patience = 0.3;    // s for which the proxy is held before it is led back
  static constexpr double report_after = 1;  // s; if a proxy is held longer without a way back, a fault is reported
  // m; the proxy is led back only to a point of the path that is nearer to the hand than the proxy by this much
  static constexpr double gain = 0.1e-3;
  static constexpr double slew = 14;  // N/s, largest rate of change of the force while the proxy is led back
  // m, distance of the proxy from tissue; beyond this, the recorded path starts again
  static constexpr double outside = 1e-3;
  // voxels between the examined points on the line from proxy to hand
  static constexpr double search_step = 1;
};

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

/// Detects a proxy that contacts hold although the hand has moved away (under an overhang, behind a ledge), and leads
/// it back along its path, to the point nearest to the hand. Nothing is cut meanwhile. Servo thread only.
struct Retreat {
  double unit;       // m, unit of the positions
  double path_unit;  // voxel of `path`, in `unit`
  RetreatPath path{};
  dvec3 held_at{0};      // position at which contacts hold the proxy
  double held_for = 0;   // s, time that the proxy has been near held_at, far from the hand
  bool leading = false;  // true: the proxy is led back along its path
  std::size_t to = 0;    // index of the path point to which the proxy is led back
  bool wedged = false;   // true: the hand has moved away, but no point of the path is clearly nearer to the hand

  void forget() noexcept {
    leading = wedged = false;
    held_for = 0;
  }
  /// Records the proxy's position `c`. `outside`: the head is far from tissue. Returns true if contacts have held the
  /// proxy far from the hand for so long that the caller must test whether the hand has moved away.
  bool is_held(const dvec3& c, const dvec3& hand, bool outside, double dt) noexcept;
  /// The hand has moved away from the proxy at `c`: begins to lead the proxy back, or sets `wedged`.
  void begin(const dvec3& c, const dvec3& hand) noexcept;
  /// If `leading`: moves `c` back by at most `max_step`. Returns false if the proxy is not led back in this tick.
  bool lead(const dvec3& hand, double max_step, dvec3& c) noexcept;
};

}  // namespace typodont::haptics
