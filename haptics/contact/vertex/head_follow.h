// Moves a tool's head as near to the hand as contact points allow.
#pragma once

#include <algorithm>
#include <vector>

#include "haptics/contact/proxy/active_set.h"
#include "haptics/contact/vertex/head_distances.h"
#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/mesh/near_points.h"

namespace typodont::haptics::vertex {

/// Lengths in radii of the head.
struct FollowParameters {
  // In radii, largest motion of the head per iteration; short, because limits by points are linear approximations.
  static constexpr double step = 0.15;
  // Iterations per round. After a round, the list of points is made again if the head has moved by more than `kept`.
  static constexpr int looks = 2;
  // Largest number of rounds per tick. Near contact points, the head thus moves at most 16 × 2 × 0.15 = 4.8 radii.
  static constexpr int rounds = 16;
  // The head's motion ends after a step that is shorter than this × the longest allowed step.
  static constexpr double settled = 0.2;
  // In radii. If a point is deeper inside the head than this, the head counts as inside tissue and is moved out.
  static constexpr double led_out = 0.05;
  /// In radii; after a longer motion of the tool's head, the list of near mesh points is made again.
  static constexpr double kept = 0.15;
  /// In radii, distance from the tool's head within which mesh points are listed.
  static constexpr double margin = kept + looks * step;
  /// Largest motion of the head per iteration, m. `left`: distance of the head from the hand, m.
  static double longest_step(double radius, double left) noexcept {
    return std::clamp(left, 0.01 * radius, step * radius);
  }
};

/// How far a head may move towards a point at this distance, m. `give` true: a point inside the head only prevents a
/// deeper overlap; otherwise an overlap of `allowed_depth` (m) is allowed.
inline double allowed_motion(double distance, double allowed_depth, bool give) noexcept {
  return give ? std::max(distance, 0.0) : distance + allowed_depth;
}

/// Moves the head until contact points are near. No step is longer than the range of the list of points, so the head
/// cannot jump over a thin wall. `list(p)`: updates the list, if needed, after each step. Returns the head's position.
template <class List>
dvec3 advance_free(const mesh::NearPoints& points, dvec3 from, const dvec3& to, double radius, List&& list) noexcept {
  constexpr int kMaxHops = 64;  // largest number of steps without contact per tick
  const double free = (FollowParameters::margin - FollowParameters::kept) * radius;
  for (int hop = 0; points.empty() && from != to && hop < kMaxHops; ++hop) {
    const dvec3 rest = to - from;
    const double left = glm::length(rest);
    from = left > free ? from + free / left * rest : to;
    list(from);
  }
  return from;
}

/// Keeps a head outside the mesh, as near to the hand as possible. Servo thread only; allocates in the constructor
/// only.
class HeadFollower {
 public:
  /// A contact point that stops the head.
  struct Hold {
    std::uint32_t point;  // index of the point
    dvec3 n;              // unit vector, direction in which the point pushes the head
    double push;          // m, distance by which the point displaces the head from the hand
  };

  /// `distances`: buffer of the caller, which is overwritten. It must outlive this object.
  explicit HeadFollower(HeadDistances& distances) : distances_(distances) {
    gaps_.resize(distances.most() + HeadDistances::kBatch);
  }

  /// Moves the head from `from` towards the hand at X_WT, in the hand's orientation. Returns the head's position. Near
  /// points limit each step. `allowed_depth`: m, allowed overlap. `give` true: points inside the head only prevent a
  /// deeper overlap. `list(p)`: updates `points` for a head at p. `complete(p, far)`: adds missing points; returns how
  /// far (m), at most `far`, the head may move from p. If `may_go_on()` is false, the motion stops until the next tick.
  template <class List, class Complete, class MayGoOn>
  dvec3 follow(const VertexHead& head, mesh::NearPoints& points, dvec3 from, const Pose& X_WT, double allowed_depth,
               bool give, List&& list, Complete&& complete, MayGoOn&& may_go_on) noexcept {
    led_out_ = false;
    for (int round = 0; round < FollowParameters::rounds && (round == 0 || may_go_on()); ++round) {
      list(from);
      from = advance_free(points, from, X_WT.p, head.radius(), list);
      if (points.empty()) break;
      bool more = true;
      for (int look = 0; look < FollowParameters::looks && more; ++look) {
        const double most = complete(from, FollowParameters::longest_step(head.radius(), glm::distance(from, X_WT.p)));
        if (!(most > 0)) return from;
        more = approach(head, points, from, X_WT, allowed_depth, give, most);
      }
      if (!more) break;
    }
    return from;
  }

  /// Returns true if the last follow() found points deeper inside the head than FollowParameters::led_out.
  bool led_out() const noexcept { return led_out_; }
  /// Returns true if contact points limited the last step of follow().
  bool bounded() const noexcept { return bounded_; }
  int count() const noexcept { return active_.count; }
  const Hold& hold(int i) const noexcept { return holds_[i]; }

 private:
  /// Makes one step of the head of at most `most` (m). Returns true if a further step is useful.
  bool approach(const VertexHead& head, mesh::NearPoints& points, dvec3& at, const Pose& X_WT, double allowed_depth,
                bool give, double most) noexcept;

  HeadDistances& distances_;
  std::vector<double> gaps_;  // m, for each point: allowed motion of the head towards the point
  ActivePlanes active_;
  Hold holds_[3] = {};
  bool bounded_ = false, led_out_ = false;
};

}  // namespace typodont::haptics::vertex
