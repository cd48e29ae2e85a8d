// Distances from a head, and where vertices inside go (S4, section 3).
#pragma once

#include <array>
#include <cmath>

#include "haptics/tool.h"

namespace typodont::haptics::vertex {

/// Points must not enter. Any thread; allocates at construction only. m, T.
class VertexHead {
 public:
  explicit VertexHead(const Tool& tool);

  bool is_ball() const noexcept { return ball_; }
  /// Meridian, m; not for a ball.
  const HeadField& field() const noexcept { return field_; }
  double radius() const noexcept { return radius_; }
  /// m, centre to farthest point.
  double reach() const noexcept { return reach_; }
  /// Part of the axis, m, T: its ends are centres of the largest balls that touch the head's ends. A ball's is its
  /// centre.
  double core_low() const noexcept { return core_low_; }
  double core_high() const noexcept { return core_high_; }

  /// m, half the box, W. `axis_W`: unit.
  dvec3 half_box(const dvec3& axis_W) const noexcept {
    return ball_ ? dvec3(radius_)
                 : half_ * glm::abs(axis_W) + radius_ * glm::sqrt(glm::max(1.0 - axis_W * axis_W, 0.0));
  }
  /// False: certainly farther than `far` (m). `off`: m from the centre, up to 1 cm.
  bool may_be_within(const glm::vec3& off, const glm::vec3& axis, float far) const noexcept {
    constexpr float kRounding = 1e-8f;  // m, rounding of floats
    const float room = far + kRounding, square = glm::dot(off, off), reach = static_cast<float>(reach_) + room;
    if (square > reach * reach || ball_) return square <= reach * reach;
    const float along = glm::dot(off, axis), wide = static_cast<float>(radius_) + room;
    if (std::abs(along) > static_cast<float>(half_) + room || square - along * along > wide * wide) return false;
    // Outlines are convex.
    constexpr float kRoundingOfSquares = 1e-6f;  // rounding of `outer` / `square`
    const float outer = square - along * along - kRoundingOfSquares * square;
    for (int i = 0; i < flank_count_; ++i) {
      const Flank& flank = flank_[i];
      const float most = flank.far + flank.per_far * room - flank.slope * along;  // m, largest distance from the axis
      if (most < 0 || outer > most * most) return false;
    }
    return true;
  }

  /// m, p_TQ, negative inside. `n_T`: unit direction of increase.
  double distance(const dvec3& p_TQ, dvec3& n_T) const noexcept {
    if (!ball_) return field_.distance(p_TQ, n_T);
    const double length = glm::length(p_TQ);
    n_T = length > 0 ? p_TQ / length : dvec3(0, 0, -1);
    return length - radius_;
  }
  double distance(const dvec3& p_TQ) const noexcept {
    return ball_ ? glm::length(p_TQ) - radius_ : field_.distance(p_TQ);
  }
  /// m, from inside along unit `way_T`.
  double distance_to_surface(const dvec3& p_TQ, const dvec3& way_T) const noexcept;
  /// As printed in S4: from a ball's centre (3.1), in a round end from its centre, otherwise from the axis at the same
  /// height (3.3, 3.6).
  dvec3 as_printed(const dvec3& p_TQ) const noexcept;

 private:
  /// At z (m, T) within far - slope·z of the axis; within d of the head, per_far·d more.
  struct Flank {
    float far, slope, per_far;
  };
  void find_flanks() noexcept;
  void find_core() noexcept;

  Tool tool_;
  HeadField field_;
  bool ball_;
  // m: largest radius; centre to farthest point; half length.
  double radius_, reach_, half_;
  double core_low_ = 0, core_high_ = 0;
  std::array<Flank, HeadField::kMaxPieces> flank_{};  // tangents at the inclined pieces of the outline
  int flank_count_ = 0;
};

}  // namespace typodont::haptics::vertex
