#include "haptics/contact/vertex/vertex_head.h"

#include <algorithm>
#include <cmath>

namespace typodont::haptics::vertex {

VertexHead::VertexHead(const Tool& tool)
    : tool_(tool),
      field_(tool, 1.0),
      ball_(tool.shape == HeadShape::kSphere),
      radius_(tool.radius()),
      reach_(tool.reach()),
      half_(tool.half()) {}

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
