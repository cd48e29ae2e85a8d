// Distances from a head, and target positions of vertices inside it (paper S4 in docs/papers.md, section 3).
#pragma once

#include <array>
#include <cmath>

#include "haptics/tool.h"

namespace typodont::haptics::vertex {

/// The shape of a head, for distances of points. Any thread; allocates at construction only. Lengths in m, frame T.
class VertexHead {
 public:
  explicit VertexHead(const Tool& tool);

  bool is_ball() const noexcept { return ball_; }
  /// Meridian (half outline) of the head, m; not valid for a ball.
  const HeadField& field() const noexcept { return field_; }
  double radius() const noexcept { return radius_; }
  /// Distance from the head's centre to its farthest point, m.
  double reach() const noexcept { return reach_; }
  /// Ends of a part of the head's axis (m, frame T): the centres of the largest balls inside the head that touch the
  /// head's two ends. For a ball, both are its centre.
  double core_low() const noexcept { return core_low_; }
  double core_high() const noexcept { return core_high_; }

  /// Half the edges of the head's bounding box in frame W, m. `axis_W`: unit vector of the head's axis.
  dvec3 half_box(const dvec3& axis_W) const noexcept {
    return ball_ ? dvec3(radius_)
                 : half_ * glm::abs(axis_W) + radius_ * glm::sqrt(glm::max(1.0 - axis_W * axis_W, 0.0));
  }
  /// Returns false if a point is certainly farther than `far` (m). `off`: vector from the head's centre, m, up to 1 cm.
  bool may_be_within(const glm::vec3& off, const glm::vec3& axis, float far) const noexcept {
    constexpr float kRounding = 1e-8f;  // m, rounding error of floats
    const float margin = far + kRounding, square = glm::dot(off, off), reach = static_cast<float>(reach_) + margin;
    if (square > reach * reach || ball_) return square <= reach * reach;
    const float along = glm::dot(off, axis), wide = static_cast<float>(radius_) + margin;
    if (std::abs(along) > static_cast<float>(half_) + margin || square - along * along > wide * wide) return false;
    // A head's outline is convex, so all of it lies inside the tangents at its inclined pieces.
    constexpr float kRoundingOfSquares = 1e-6f;  // relative to squared distances: rounding error
    const float outer = square - along * along - kRoundingOfSquares * square;
    for (int i = 0; i < flank_count_; ++i) {
      const Flank& flank = flank_[i];
      const float most = flank.far + flank.per_far * margin - flank.slope * along;  // m, limit of distance from axis
      if (most < 0 || outer > most * most) return false;
    }
    return true;
  }

  /// Signed distance of p_TQ, m, negative inside. `n_T`: unit vector in whose direction the distance increases.
  double distance(const dvec3& p_TQ, dvec3& n_T) const noexcept {
    if (!ball_) return field_.distance(p_TQ, n_T);
    const double length = glm::length(p_TQ);
    n_T = length > 0 ? p_TQ / length : dvec3(0, 0, -1);
    return length - radius_;
  }
  double distance(const dvec3& p_TQ) const noexcept {
    return ball_ ? glm::length(p_TQ) - radius_ : field_.distance(p_TQ);
  }
  /// Distance of a point inside the head to the head's surface along the unit vector `direction_T`, m.
  double distance_to_surface(const dvec3& p_TQ, const dvec3& direction_T) const noexcept;
  /// Target position of a vertex by equations 3.1, 3.3 and 3.6 of paper S4 (docs/papers.md): away from the centre of a
  /// ball or round end, otherwise away from the axis at the same height.
  dvec3 as_printed(const dvec3& p_TQ) const noexcept;

 private:
  /// At height z (m, frame T), the head is within far - slope·z of the axis. Points nearer than d (m) to the head may
  /// be farther from the axis by per_far·d.
  struct Flank {
    float far, slope, per_far;
  };
  void find_flanks() noexcept;
  void find_core() noexcept;

  Tool tool_;
  HeadField field_;
  bool ball_;
  // m: largest radius; distance from the head's centre to its farthest point; half the length
  double radius_, reach_, half_;
  double core_low_ = 0, core_high_ = 0;
  std::array<Flank, HeadField::kMaxPieces> flank_{};  // tangents at the inclined pieces of the outline
  int flank_count_ = 0;
};

}  // namespace typodont::haptics::vertex
