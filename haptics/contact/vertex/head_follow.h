// As near to the hand as contact points allow.
#pragma once

#include <algorithm>
#include <vector>

#include "haptics/contact/proxy/active_set.h"
#include "haptics/contact/vertex/head_distances.h"
#include "haptics/contact/vertex/plane_projection.h"
#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/mesh/near_points.h"

namespace typodont::haptics::vertex {

/// In the head's radius.
struct FollowParameters {
  // Per iteration, short: the points' bounds are linear approximations.
  static constexpr double step = 0.15;
  // Iterations per round; then a new list if the head moved by more than `kept`.
  static constexpr int looks = 2;
  // Rounds per tick: at most 16 × 2 × 0.15 = 4.8 radii near points.
  static constexpr int rounds = 16;
  // Of the longest allowed step; shorter ones end it.
  static constexpr double settled = 0.2;
  // Depth of a point in the head, beyond which the head is inside and is moved out.
  static constexpr double led_out = 0.05;
  /// Motion until points are listed again.
  static constexpr double kept = 0.15;
  /// From the head, of listed points.
  static constexpr double margin = kept + looks * step;
  /// m per iteration. `left`: m to the hand.
  static double longest_step(double radius, double left) noexcept {
    return std::clamp(left, 0.01 * radius, step * radius);
  }
};

/// Until points are near, in steps within the list, so no thin wall is jumped. `list(p)` after each step lists around p
/// if needed. Returns the head's position.
template <class List>
dvec3 advance_free(const mesh::NearPoints& points, dvec3 from, const dvec3& to, double radius, List&& list) noexcept {
  constexpr int kMostHops = 64;  // steps without contact per tick
  const double free = (FollowParameters::margin - FollowParameters::kept) * radius;
  for (int hop = 0; points.empty() && from != to && hop < kMostHops; ++hop) {
    const dvec3 rest = to - from;
    const double left = glm::length(rest);
    from = left > free ? from + free / left * rest : to;
    list(from);
  }
  return from;
}

/// Outside the mesh, after the hand. Servo thread; allocates in the constructor only.
class HeadFollower {
 public:
  /// Holds the head back.
  struct Hold {
    std::uint32_t point;  // index of the point
    dvec3 n;              // unit vector on the head
    double push;          // m from the hand
  };

  /// `distances`: the caller's buffer, which must outlive this and is overwritten.
  explicit HeadFollower(HeadDistances& distances) : distances_(distances) {
    gaps_.resize(distances.most() + HeadDistances::kBatch);
  }

  /// Moves the head from `from` towards the hand at X_WT, in the hand's orientation. Returns the final position.
  ///
  /// Each point near the head gives a linear inequality for the step of the head. A head is convex, so the distance of
  /// a point from it is a convex function. So after a step that satisfies all inequalities, no point is inside the
  /// head.
  ///
  /// `slack`: m, allowed overlap of head and points. `give`: if true, a point that is already inside the head does not
  /// push the head out, but only prevents a deeper overlap.
  /// `list(p)`: makes a new list of the points around the position p if `points` is no longer valid there. A fast head
  /// needs several lists in one tick.
  /// `complete(p, far)`: adds missing points to the list, so that the head at p can move by `far` (m) in any direction
  /// without meeting an unlisted point. Returns the length (m) by which the head can move: `far`, or less if points are
  /// still missing. The head moves at most by this length.
  /// `may_go_on()`: if it returns false, the head stops until the next tick.
  template <class List, class Complete, class MayGoOn>
  dvec3 follow(const VertexHead& head, mesh::NearPoints& points, dvec3 from, const Pose& X_WT, double slack, bool give,
               List&& list, Complete&& complete, MayGoOn&& may_go_on) noexcept {
    led_out_ = false;
    for (int round = 0; round < FollowParameters::rounds && (round == 0 || may_go_on()); ++round) {
      list(from);
      from = advance_free(points, from, X_WT.p, head.radius(), list);
      if (points.empty()) break;
      bool more = true;
      for (int look = 0; look < FollowParameters::looks && more; ++look) {
        const double most = complete(from, FollowParameters::longest_step(head.radius(), glm::distance(from, X_WT.p)));
        if (!(most > 0)) return from;
        more = approach(head, points, from, X_WT, slack, give, most);
      }
      if (!more) break;
    }
    return from;
  }

  /// In the last follow(), deeper than FollowParameters::led_out.
  bool led_out() const noexcept { return led_out_; }
  /// At its last step.
  bool bounded() const noexcept { return bounded_; }
  int count() const noexcept { return active_.count; }
  const Hold& hold(int i) const noexcept { return holds_[i]; }

 private:
  /// At most `most` (m). True: go on.
  bool approach(const VertexHead& head, mesh::NearPoints& points, dvec3& at, const Pose& X_WT, double slack, bool give,
                double most) noexcept;

  HeadDistances& distances_;
  std::vector<double> gaps_;  // m of motion towards each point
  ActivePlanes active_;
  Hold holds_[3] = {};
  bool bounded_ = false, led_out_ = false;
};

}  // namespace typodont::haptics::vertex
