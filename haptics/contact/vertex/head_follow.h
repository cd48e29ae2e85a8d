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
  // Longest displacement of the head in one iteration, as a ratio to the head's radius. It is short, because each
  // contact point limits the displacement only by a linear approximation.
  static constexpr double step = 0.15;
  static constexpr int looks = 2;  // number of iterations after which the near points are listed again
  // Largest number of times that points are listed in one tick; it limits the head's motion to 4.8 radii per tick.
  static constexpr int rounds = 16;
  // Convergence tolerance: the iterations end when a displacement is shorter than this fraction of
  // `step`.
  static constexpr double settled = 0.2;
  // If head and points overlap by more than this (as a ratio to the head's radius), the head counts as inside the
  // tissue and is moved out.
  static constexpr double led_out = 0.05;
  /// When the head has moved farther than this, as a ratio to its radius, the near points are listed again.
  static constexpr double kept = 0.15;
  /// Distance from the head within which points are listed, as a ratio to the head's radius.
  static constexpr double margin = kept + looks * step;
  /// Returns the longest displacement in one iteration, m. `left`: distance to the hand, m.
  static double longest_step(double radius, double left) noexcept {
    return std::clamp(left, 0.01 * radius, step * radius);
  }
};

/// Moves a head towards `to` until points are near. A step is at most as long as the search distance for points, so
/// that the head cannot jump through a thin wall. `list(p)` must list the points around p, unless the present list is
/// still valid.
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
  /// A contact point that holds the head at its final position.
  struct Hold {
    std::uint32_t point;  // index of the point
    dvec3 n;              // unit direction in which the point pushes the head
    double push;          // m, distance by which the point holds the head back from the hand
  };

  /// `distances` is a buffer of the caller; it must exist as long as this object. follow() overwrites its contents.
  explicit HeadFollower(HeadDistances& distances) : distances_(distances) {
    gaps_.resize(distances.most() + HeadDistances::kBatch);
  }

  /// Moves the head from `from` towards the hand at X_WT, in the hand's orientation. Returns the final position. Each
  /// near point gives a linear bound on a step. The distance to a convex head is a convex function; so after a step
  /// that satisfies all bounds, no point is inside the head. `slack`: allowed overlap, m. `give`: a point that is
  /// already inside the head only prevents a deeper overlap. `list(p)` must list the points around p, unless the
  /// present list is still valid. A fast head needs several lists in one tick; otherwise it would lag behind the hand.
  /// `complete(p, far)` must add the points within the distance `far` (m) of the head at p that the list lacks, and
  /// return `far`. Or it returns a shorter step for which the present list is complete; if this step is 0, the head
  /// stops. If `may_go_on()` returns false, no further list is made in this tick, and the head stops where its last
  /// list is no longer valid.
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

  /// Returns true if a point was deep inside the head in the last follow().
  bool led_out() const noexcept { return led_out_; }
  /// Returns true if there were points near the head in the last follow().
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
