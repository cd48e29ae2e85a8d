// A head that points hold off: where it comes to lie on its way towards the hand.
#pragma once

#include <vector>

#include "haptics/contact/proxy/active_set.h"
#include "haptics/contact/vertex/plane_projection.h"
#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/mesh/near_points.h"

namespace typodont::haptics::vertex {

/// Lengths as multiples of the head's radius.
struct FollowParameters {
  static constexpr double step = 0.15;     // the head's longest way in one look, as the points' bounds are linear
  static constexpr int looks = 2;          // with one list of points
  static constexpr int rounds = 16;        // lists of points in a tick, at most: 4.8 radii of way
  static constexpr double settled = 0.2;   // of `step`: after a shorter way no other look is needed
  static constexpr double led_out = 0.05;  // overlap above which the head was found in tissue
  /// Way from the place where the points were listed, beyond which they must be listed anew.
  static constexpr double kept = 0.15;
  /// How far beyond the head the points must be listed.
  static constexpr double margin = kept + looks * step;
};

/// Where a head on its way to `to` comes while no point is near it: it goes no farther at once than points were looked
/// for, so no leap passes a thin wall. `list(p)`: lists the points around p, where those that are listed do not reach.
template <class List>
dvec3 advance_free(const mesh::NearPoints& points, dvec3 from, const dvec3& to, double radius, List&& list) noexcept {
  constexpr int kMostHops = 64;  // in one tick
  const double free = (FollowParameters::margin - FollowParameters::kept) * radius;
  for (int hop = 0; points.empty() && from != to && hop < kMostHops; ++hop) {
    const dvec3 rest = to - from;
    const double left = glm::length(rest);
    from = left > free ? from + free / left * rest : to;
    list(from);
  }
  return from;
}

/// Servo thread; allocates at construction only.
class HeadFollower {
 public:
  /// A point that holds the head where it came to lie.
  struct Hold {
    std::uint32_t point;  // its index
    dvec3 n;              // unit, the way the head is pushed
    double push;          // m
  };

  explicit HeadFollower(std::size_t most_points) { bounds_.reserve(most_points), points_.reserve(most_points); }

  /// The head's way from `from` towards the hand at X_WT, in its orientation. Distance to a convex head is convex, so a
  /// step that keeps the bounds of all points overlaps none. `slack`: m that it may overlap them. `give`: points that
  /// it overlaps only keep it from going deeper. `list(p)`: lists the points around p, where those that are listed do
  /// not reach; a head that is fast for its size needs several lists in a tick, or it stays behind the hand. Returns
  /// where the head comes to lie.
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

  /// Of the last follow(): a point was deep in the head.
  bool led_out() const noexcept { return led_out_; }
  /// Of the last follow(): there were points near the head.
  bool bounded() const noexcept { return !bounds_.empty(); }
  int count() const noexcept { return active_.count; }
  Hold hold(int i) const noexcept {
    const auto at = static_cast<std::size_t>(active_.index[i]);
    return {points_[at], bounds_[at].n, active_.push[i]};
  }

 private:
  /// Moves the head as far as the listed points reach. True if it is still on its way.
  bool approach(const VertexHead& head, mesh::NearPoints& points, dvec3& at, const Pose& X_WT, double slack,
                bool give) noexcept;

  std::vector<StepBound> bounds_;      // of the last look
  std::vector<std::uint32_t> points_;  // to which they belong
  ActivePlanes active_;
  bool led_out_ = false;
};

}  // namespace typodont::haptics::vertex
