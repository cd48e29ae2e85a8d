// The shape of a head for the contact model "vertex": distances of points from the head, and the positions to which
// vertices inside the head are moved (paper S4, section 3).
#pragma once

#include <array>
#include <cmath>

#include "haptics/tool.h"

namespace typodont::haptics::vertex {

/// The head of one tool, as a shape that points must not enter. Any thread; never allocates after construction. Lengths
/// in metres, vectors in the tool's frame T.
class VertexHead {
 public:
  explicit VertexHead(const Tool& tool);

  bool is_ball() const noexcept { return ball_; }
  /// Returns the distance field of the head's meridian (its outline), in metres. A ball does not need it.
  const HeadField& field() const noexcept { return field_; }
  double radius() const noexcept { return radius_; }
  /// Returns the distance from the head's centre to its farthest point, m.
  double reach() const noexcept { return reach_; }
  /// The core of the head is the part of its axis between these heights (m, frame T). Each end of the core is the
  /// centre of the largest ball inside the head that touches the head's end. The core of a ball is its centre.
  double core_low() const noexcept { return core_low_; }
  double core_high() const noexcept { return core_high_; }

  /// Returns half the edge lengths (m) of the head's bounding box, along the axes of the workbench frame W. `axis_W`:
  /// unit vector along the head's axis.
  dvec3 half_box(const dvec3& axis_W) const noexcept {
    return ball_ ? dvec3(radius_)
                 : half_ * glm::abs(axis_W) + radius_ * glm::sqrt(glm::max(1.0 - axis_W * axis_W, 0.0));
  }
  /// Quick test, which is cheaper than distance(). Returns false if a point is certainly farther than `far` (m) from
  /// the head. A result of true proves nothing: the point may be near or far. `off`: m, vector from the head's centre
  /// to the point, at most 1 cm long.
  bool may_be_within(const glm::vec3& off, const glm::vec3& axis, float far) const noexcept {
    constexpr float kRounding = 1e-8f;  // m, upper bound of the rounding error of floats
    const float room = far + kRounding, square = glm::dot(off, off), reach = static_cast<float>(reach_) + room;
    if (square > reach * reach || ball_) return square <= reach * reach;
    const float along = glm::dot(off, axis), wide = static_cast<float>(radius_) + room;
    if (std::abs(along) > static_cast<float>(half_) + room || square - along * along > wide * wide) return false;
    // No point of the head is beyond a tangent of its outline, because the outline is convex.
    constexpr float kRoundingOfSquares = 1e-6f;  // ratio of the rounding error of `outer` to `square`
    const float outer = square - along * along - kRoundingOfSquares * square;
    for (int i = 0; i < flank_count_; ++i) {
      const Flank& flank = flank_[i];
      const float most = flank.far + flank.per_far * room - flank.slope * along;  // m, largest distance from the axis
      if (most < 0 || outer > most * most) return false;
    }
    return true;
  }

  /// Returns the signed distance (m) of the point p_TQ from the head's surface, negative inside. `n_T` receives the
  /// unit direction in which the distance increases.
  double distance(const dvec3& p_TQ, dvec3& n_T) const noexcept {
    if (!ball_) return field_.distance(p_TQ, n_T);
    const double length = glm::length(p_TQ);
    n_T = length > 0 ? p_TQ / length : dvec3(0, 0, -1);
    return length - radius_;
  }
  double distance(const dvec3& p_TQ) const noexcept {
    return ball_ ? glm::length(p_TQ) - radius_ : field_.distance(p_TQ);
  }
  /// Returns the distance from a point inside the head to the surface along the unit direction `way_T`, m.
  double distance_to_surface(const dvec3& p_TQ, const dvec3& way_T) const noexcept;
  /// Returns the position on the head's surface to which the rules printed in paper S4 move a point inside the head. In
  /// a ball (equation 3.1), the point moves away from the ball's centre. In the half ball at the end of a round-ended
  /// head, it moves away from the centre of the half ball. In all other cases, it moves away from the head's axis and
  /// keeps its height along the axis (equations 3.3 and 3.6).
  dvec3 as_printed(const dvec3& p_TQ) const noexcept;

 private:
  /// A tangent of the head's outline. At the height z along the axis (m, frame T), points of the head are at most
  /// far - slope·z from the axis. Points within a distance d of the head are at most per_far·d farther from the axis.
  struct Flank {
    float far, slope, per_far;
  };
  void find_flanks() noexcept;
  void find_core() noexcept;

  Tool tool_;
  HeadField field_;
  bool ball_;
  // m. radius_: largest radius of the head; reach_: distance from the head's centre to its farthest point; half_: half
  // the head's length.
  double radius_, reach_, half_;
  double core_low_ = 0, core_high_ = 0;
  std::array<Flank, HeadField::kMaxPieces> flank_{};  // tangents at the inclined pieces of the outline
  int flank_count_ = 0;
};

}  // namespace typodont::haptics::vertex
