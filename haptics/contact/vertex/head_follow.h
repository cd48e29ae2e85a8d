// Moves a head towards the hand as far as the contact points allow.
#pragma once

#include <algorithm>
#include <vector>

#include "haptics/contact/proxy/active_set.h"
#include "haptics/contact/vertex/head_distances.h"
#include "haptics/contact/vertex/plane_projection.h"
#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/mesh/near_points.h"

namespace typodont::haptics::vertex {

/// Parameters for the motion of a head among contact points. Lengths are ratios to the head's radius.
struct FollowParameters {
  // Longest displacement of the head in one iteration, as a ratio to the head's radius. It is short, because the limit
  // that a contact point sets is only a linear approximation, which is inaccurate for long displacements.
  static constexpr double step = 0.15;
  // Number of iterations in one round. After a round, the points near the head are listed again if the head has moved
  // farther than `kept`.
  static constexpr int looks = 2;
  // Largest number of rounds in one tick. Near contact points, the head moves at most 16 × 2 × 0.15 = 4.8 radii in a
  // tick.
  static constexpr int rounds = 16;
  // Convergence tolerance: the iterations end when the displacement in one iteration is shorter than this fraction of
  // the longest displacement that is allowed in this iteration.
  static constexpr double settled = 0.2;
  // Limit of the depth of a contact point inside the head, as a ratio to the head's radius. If a point is deeper, the
  // head counts as inside the tissue and is moved out.
  static constexpr double led_out = 0.05;
  /// Ratio to the head's radius. When the head has moved farther than this since the points near it were listed, they
  /// are listed again.
  static constexpr double kept = 0.15;
  /// Distance from the head within which points are listed, as a ratio to the head's radius.
  static constexpr double margin = kept + looks * step;
  /// Returns the longest allowed displacement in one iteration, m. `left`: distance from the head to the hand, m.
  static double longest_step(double radius, double left) noexcept {
    return std::clamp(left, 0.01 * radius, step * radius);
  }
};

/// Moves a head from `from` towards `to` until contact points are near it. A step is never longer than the distance
/// within which points are listed, so the head cannot jump through a thin wall. `list(p)` is called after each step. It
/// must list the points around p if the present list is no longer valid. Returns the head's position.
template <class List>
dvec3 advance_free(const mesh::NearPoints& points, dvec3 from, const dvec3& to, double radius, List&& list) noexcept {
  constexpr int kMostHops = 64;  // largest number of steps without contact in one tick
  const double free = (FollowParameters::margin - FollowParameters::kept) * radius;
  for (int hop = 0; points.empty() && from != to && hop < kMostHops; ++hop) {
    const dvec3 rest = to - from;
    const double left = glm::length(rest);
    from = left > free ? from + free / left * rest : to;
    list(from);
  }
  return from;
}

/// Keeps a head outside the mesh while it follows the hand. Servo thread only. Allocates memory only in the
/// constructor.
class HeadFollower {
 public:
  /// A contact point that prevents the head from coming nearer to the hand.
  struct Hold {
    std::uint32_t point;  // index of the point
    dvec3 n;              // unit direction in which the point pushes the head
    double push;          // m, distance by which the point holds the head back from the hand
  };

  /// `distances` is a buffer of the caller. It must exist as long as this object. follow() overwrites its contents.
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

  /// Returns true if, in the last follow(), a point was deeper inside the head than FollowParameters::led_out allows.
  bool led_out() const noexcept { return led_out_; }
  /// Returns true if there were points near the head at its last step.
  bool bounded() const noexcept { return bounded_; }
  int count() const noexcept { return active_.count; }
  const Hold& hold(int i) const noexcept { return holds_[i]; }

 private:
  /// Makes one step of the head of at most `most` (m), as far as the listed points allow. Returns true if a further
  /// iteration is needed.
  bool approach(const VertexHead& head, mesh::NearPoints& points, dvec3& at, const Pose& X_WT, double slack, bool give,
                double most) noexcept;

  HeadDistances& distances_;
  std::vector<double> gaps_;  // m, for each near point: the distance that the head may move towards it
  ActivePlanes active_;
  Hold holds_[3] = {};
  bool bounded_ = false, led_out_ = false;
};

}  // namespace typodont::haptics::vertex
