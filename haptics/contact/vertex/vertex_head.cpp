#include "haptics/contact/vertex/vertex_head.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace typodont::haptics::vertex {

VertexHead::VertexHead(const Tool& tool)
    : tool_(tool),
      field_(tool, 1.0),
      ball_(tool.shape == HeadShape::kSphere),
      radius_(tool.radius()),
      reach_(tool.reach()),
      half_(tool.half()) {
  if (!ball_) find_flanks(), find_core();
}

/// Finds a tangent for each piece of the outline that is neither parallel nor perpendicular to the axis: the tangent
/// has the direction of the straight piece, or of the middle of the arc.
void VertexHead::find_flanks() noexcept {
  constexpr double kInclined = 0.02;  // smallest component of the unit normal of a piece along and across the axis
  constexpr double kRounding = 1e-7;  // m, larger than the rounding error of the floats in may_be_within()
  const std::span pieces = std::span(field_.pieces).first(static_cast<std::size_t>(field_.count));
  for (const HeadField::Piece& piece : pieces) {
    const double chord = std::hypot(piece.dx, piece.dz);
    if (!(chord > 0)) continue;
    // Unit normal (ρ, z) of the chord from a to b. It is also the normal at the middle of an arc.
    const double n_rho = piece.dz / chord, n_z = -piece.dx / chord;
    if (n_rho < kInclined || std::abs(n_z) < kInclined) continue;
    // The largest extent of the outline along this normal, over all pieces.
    double extent = -1;
    for (const HeadField::Piece& other : pieces) {
      extent = std::max({extent, n_rho * other.ax + n_z * other.az, n_rho * other.bx + n_z * other.bz});
      // The arc reaches farther than its ends if the normal points from its centre to a place between the ends.
      const bool between = (other.ax - other.cx) * n_z - (other.az - other.cz) * n_rho >= 0 &&
                           n_rho * (other.bz - other.cz) - n_z * (other.bx - other.cx) >= 0;
      if (other.radius > 0 && between) extent = std::max(extent, n_rho * other.cx + n_z * other.cz + other.radius);
    }
    flank_[static_cast<std::size_t>(flank_count_++)] = {static_cast<float>((extent + kRounding) / n_rho),
                                                        static_cast<float>(n_z / n_rho), static_cast<float>(1 / n_rho)};
  }
}

/// Finds the core (core_low()). A ball around a point of the axis that touches the head's end is inside the head if its
/// radius is the distance of the point from the surface. The largest such ball is found by bisection.
void VertexHead::find_core() noexcept {
  constexpr double kTolerance = 1e-9;  // m
  const auto end_of_core = [&](double end, double way) {
    double inside = 0, outside = 2 * half_;  // radii of two balls: the first one is inside the head
    for (int i = 0; i < 50; ++i) {
      const double radius = 0.5 * (inside + outside);
      (distance({0, 0, end + way * radius}) <= kTolerance - radius ? inside : outside) = radius;
    }
    return end + way * inside;
  };
  const double low = end_of_core(-half_, 1), high = end_of_core(half_, -1);
  core_low_ = std::min(low, 0.5 * (low + high)), core_high_ = std::max(high, 0.5 * (low + high));
}

/// Computes the distance from p to the head's surface along the direction `way`, by Newton's method. Along this line,
/// the signed distance from the head is a convex function. So an iteration that starts outside the head converges to
/// the surface without overshooting.
double VertexHead::distance_to_surface(const dvec3& p, const dvec3& way) const noexcept {
  if (ball_) {
    const double b = glm::dot(p, way), c = glm::dot(p, p) - radius_ * radius_;
    return -b + std::sqrt(std::max(b * b - c, 0.0));
  }
  double s = 2.1 * reach_;
  for (int i = 0; i < 40; ++i) {
    dvec3 n;
    const double d = distance(p + s * way, n), slope = glm::dot(n, way);
    if (d < 1e-13 || !(slope > 1e-9)) break;
    s -= d / slope;
  }
  return std::max(s, 0.0);
}

dvec3 VertexHead::as_printed(const dvec3& p) const noexcept {
  const bool round_end = tool_.shape == HeadShape::kRoundEndCylinder;
  const double low = radius_ - tool_.half();  // m, height of the centre of a round end along the head's axis
  if (ball_ || (round_end && p.z < low)) {
    const dvec3 c = ball_ ? dvec3(0) : dvec3(0, 0, low);
    const double length = glm::length(p - c);
    return length > 0 ? c + radius_ / length * (p - c) : p;
  }
  const double rho = std::hypot(p.x, p.y);
  if (!(rho > 0)) return p;
  const double wide = tool_.profile(p.z);
  return {p.x * wide / rho, p.y * wide / rho, p.z};
}

}  // namespace typodont::haptics::vertex
