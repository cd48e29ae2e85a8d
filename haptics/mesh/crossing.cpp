#include "haptics/mesh/crossing.h"

#include <cmath>

namespace typodont::haptics::mesh {

namespace {

/// Returns six times the signed volume of a tetrahedron. It is positive if d is behind the triangle a, b, c, whose
/// corners are counter-clockwise as seen from the front.
double volume6(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& d) {
  return glm::dot(a - d, glm::cross(b - d, c - d));
}

}  // namespace

bool passes_through(const dvec3& from, const dvec3& to, const dvec3& a, const dvec3& b, const dvec3& c) noexcept {
  constexpr double kTouches = 1e-12;  // m; a point closer to the plane than this counts as a point of the plane
  const double s = volume6(a, b, c, from), e = volume6(a, b, c, to);
  if (!(s * e < 0)) return false;
  const double in_plane = kTouches * glm::length(glm::cross(b - a, c - a));
  if (std::abs(s) < in_plane || std::abs(e) < in_plane) return false;
  const double ab = volume6(from, to, a, b), bc = volume6(from, to, b, c), ca = volume6(from, to, c, a);
  return (ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0);
}

bool cross_each_other(const Corners& a, const Corners& b) noexcept {
  int shared = 0, of_a = 0, of_b = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (a.v[i] == b.v[j]) ++shared, of_a = i, of_b = j;
    }
  }
  if (shared >= 2) return false;
  const auto edge = [](const Corners& from, int i, const Corners& t) {
    return passes_through(from.p[i], from.p[(i + 1) % 3], t.p[0], t.p[1], t.p[2]);
  };
  if (shared == 1) return edge(a, (of_a + 1) % 3, b) || edge(b, (of_b + 1) % 3, a);
  for (int i = 0; i < 3; ++i) {
    if (edge(a, i, b) || edge(b, i, a)) return true;
  }
  return false;
}

}  // namespace typodont::haptics::mesh
