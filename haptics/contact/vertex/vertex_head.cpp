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

/// Finds a tangent for each inclined piece of the head's outline: the line itself, or the tangent at an arc's middle.
void VertexHead::find_flanks() noexcept {
  // A piece is inclined if the radial and the axial component of its normal are both at least this.
  constexpr double kInclined = 0.02;
  constexpr double kRounding = 1e-7;  // m, larger than the rounding error of may_be_within()
  const std::span pieces = std::span(field_.pieces).first(static_cast<std::size_t>(field_.count));
  for (const HeadField::Piece& piece : pieces) {
    const double chord = std::hypot(piece.dx, piece.dz);
    if (!(chord > 0)) continue;
    // Normal of the chord a–b; for an arc, this is the normal at its middle.
    const double n_rho = piece.dz / chord, n_z = -piece.dx / chord;
    if (n_rho < kInclined || std::abs(n_z) < kInclined) continue;
    // How far the head's whole outline extends along the normal (n_rho, n_z), m.
    double extent = -1;
    for (const HeadField::Piece& other : pieces) {
      extent = std::max({extent, n_rho * other.ax + n_z * other.az, n_rho * other.bx + n_z * other.bz});
      // An arc may extend beyond its end points.
      const bool between = (other.ax - other.cx) * n_z - (other.az - other.cz) * n_rho >= 0 &&
                           n_rho * (other.bz - other.cz) - n_z * (other.bx - other.cx) >= 0;
      if (other.radius > 0 && between) extent = std::max(extent, n_rho * other.cx + n_z * other.cz + other.radius);
    }
    flank_[static_cast<std::size_t>(flank_count_++)] = {static_cast<float>((extent + kRounding) / n_rho),
                                                        static_cast<float>(n_z / n_rho), static_cast<float>(1 / n_rho)};
  }
}

/// Finds the centre of the largest ball that fits into each end of the head (core_low(), core_high()), by bisection. A
/// ball that touches the end is inside the head if the depth of its centre equals its radius.
void VertexHead::find_core() noexcept {
  constexpr double kTolerance = 1e-9;  // m, tolerance of the depth
  const auto end_of_core = [&](double end, double path) {
    // m, radii of balls at the end: with the radius `inside`, the ball is inside the head, with `outside` it is not
    double inside = 0, outside = 2 * half_;
    for (int i = 0; i < 50; ++i) {
      const double radius = 0.5 * (inside + outside);
      (distance({0, 0, end + path * radius}) <= kTolerance - radius ? inside : outside) = radius;
    }
    return end + path * inside;
  };
  const double low = end_of_core(-half_, 1), high = end_of_core(half_, -1);
  core_low_ = std::min(low, 0.5 * (low + high)), core_high_ = std::max(high, 0.5 * (low + high));
}

/// Uses Newton iteration. The head's distance field is convex along `path`, so the iteration converges from outside
/// without overshooting.
double VertexHead::distance_to_surface(const dvec3& p, const dvec3& path) const noexcept {
  if (ball_) {
    const double b = glm::dot(p, path), c = glm::dot(p, p) - radius_ * radius_;
    return -b + std::sqrt(std::max(b * b - c, 0.0));
  }
  double s = 2.1 * reach_;
  for (int i = 0; i < 40; ++i) {
    dvec3 n;
    const double d = distance(p + s * path, n), slope = glm::dot(n, path);
    if (d < 1e-13 || !(slope > 1e-9)) break;
    s -= d / slope;
  }
  return std::max(s, 0.0);
}

dvec3 VertexHead::as_printed(const dvec3& p) const noexcept {
  const bool round_end = tool_.shape == HeadShape::kRoundEndCylinder;
  const double low = radius_ - tool_.half();  // m, height of a round end's centre
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
