// Moves a head towards the hand as far as contact points allow.
#pragma once

#include <vector>

#include "haptics/contact/proxy/active_set.h"
#include "haptics/contact/vertex/head_distances.h"
#include "haptics/contact/vertex/plane_projection.h"
#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/mesh/near_points.h"

namespace typodont::haptics::vertex {

/// Lengths are multiples of the head's radius.
struct FollowParameters {
  // head radii, limit of the displacement in one iteration, because the bounds of the points are linear
  static constexpr double step = 0.15;
  static constexpr int looks = 2;  // number of iterations that use the same list of near points
  // limit of the number of lists per tick; with it, the head moves by at most 4.8 radii per tick
  static constexpr int rounds = 16;
  // threshold, as a ratio to `step`: after a shorter displacement no further iteration is needed
  static constexpr double settled = 0.2;
  // Threshold of the overlap, as a ratio to the head's radius: with more overlap, the head counts as inside tissue.
  static constexpr double led_out = 0.05;
  /// Limit of the head's displacement, as a ratio to its radius, after which the points must be listed again.
  static constexpr double kept = 0.15;
  /// Distance from the head up to which points must be listed, as a ratio to the head's radius.
  static constexpr double margin = kept + looks * step;
};

/// Moves a head towards `to` while no point is near it. Each hop is at most as long as the search distance for
/// points, so that no jump passes a thin wall. `list(p)`: lists the points around p, unless the present list
/// suffices.
template <class List>
dvec3 advance_free(const mesh::NearPoints& points, dvec3 from, const dvec3& to, double radius, List&& list) noexcept {
  constexpr int kMostHops = 64;  // limit of the number of hops per tick
  const double free = (FollowParameters::margin - FollowParameters::kept) * radius;
  for (int hop = 0; points.empty() && from != to && hop < kMostHops; ++hop) {
    const dvec3 rest = to - from;
    const double left = glm::length(rest);
    from = left > free ? from + free / left * rest : to;
    list(from);
  }
  return from;
}

/// Keeps a head outside the mesh while the head follows the hand. Servo thread. Allocates memory only in the
/// constructor.
class HeadFollower {
 public:
  /// A point that holds the head at its final position.
  struct Hold {
    std::uint32_t point;  // index of the point
    dvec3 n;              // unit, direction in which the point pushes the head
    double push;          // m
  };

  explicit HeadFollower(std::size_t most_points) : distances_(most_points) {
    bounds_.reserve(most_points), points_.reserve(most_points);
  }

  /// Moves the head from `from` towards the hand at X_WT, in the hand's orientation. The distance to a convex head is
  /// a convex function, so after a step that satisfies the bounds of all points, the head overlaps none of them.
  /// `slack`: m, allowed overlap. `give`: points that overlap only prevent deeper overlap. `list(p)`: lists the
  /// points around p, unless the present list suffices. A head that is fast for its size needs several lists in a
  /// tick; with one list it would lag behind the hand. Returns the final position.
  template <class List>
  dvec3 follow(const VertexHead& head, mesh::NearPoints& points, dvec3 from, const Pose& X_WT, double slack, bool give,
               List&& list) noexcept {
    led_out_ = false;
    for (int round = 0; round < FollowParameters::rounds; ++round) {
      list(from);
      from = advance_free(points, from, X_WT.p, head.radius(), list);
      if (points.empty() || !approach(head, points, from, X_WT, slack, give)) break;
    }
    return from;
  }

  /// True if in the last follow() a point was deep in the head.
  bool led_out() const noexcept { return led_out_; }
  /// True if in the last follow() there were points near the head.
  bool bounded() const noexcept { return !bounds_.empty(); }
  int count() const noexcept { return active_.count; }
  Hold hold(int i) const noexcept {
    const auto at = static_cast<std::size_t>(active_.index[i]);
    return {points_[at], bounds_[at].n, active_.push[i]};
  }

 private:
  /// Moves the head as far as the listed points allow. Returns true if the head has not arrived yet.
  bool approach(const VertexHead& head, mesh::NearPoints& points, dvec3& at, const Pose& X_WT, double slack,
                bool give) noexcept;

  HeadDistances distances_;
  std::vector<StepBound> bounds_;      // bounds of the last iteration
  std::vector<std::uint32_t> points_;  // index of the point to which each bound belongs
  ActivePlanes active_;
  bool led_out_ = false;
};

}  // namespace typodont::haptics::vertex
