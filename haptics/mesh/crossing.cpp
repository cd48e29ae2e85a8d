#include "haptics/mesh/crossing.h"

#include <cmath>

namespace typodont::haptics::mesh {

namespace {

/// Returns six times the signed volume of a tetrahedron. It is positive if d is behind the triangle a, b, c, whose
/// corners are counter-clockwise as seen from the front.
double volume6(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& d) {
  return glm::dot(a - d, glm::cross(b - d, c - d));
}

/// Continues passes_through() after its first test, with the volumes of the two ends and the face.
bool passes_between(const dvec3& from, const dvec3& to, double s, double e, const dvec3& a, const dvec3& b,
                    const dvec3& c) noexcept {
  constexpr double kTouches = 1e-12;  // m; a point closer to the plane than this counts as a point of the plane
  const double in_plane = kTouches * glm::length(glm::cross(b - a, c - a));
  if (std::abs(s) < in_plane || std::abs(e) < in_plane) return false;
  const double ab = volume6(from, to, a, b), bc = volume6(from, to, b, c), ca = volume6(from, to, c, a);
  return (ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0);
}

/// Returns true if all corners of one triangle are clearly on the same side of the plane of another one.
bool is_beside(const Corners& from, const Corners& t) noexcept {
  constexpr double kClear = 1e-10;  // m, distance from the plane that rounding errors cannot change to zero
  const dvec3 n = glm::cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
  const double clear = kClear * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
  const double a = glm::dot(n, from.p[0] - t.p[0]), b = glm::dot(n, from.p[1] - t.p[0]),
               c = glm::dot(n, from.p[2] - t.p[0]);
  return (a > clear && b > clear && c > clear) || (a < -clear && b < -clear && c < -clear);
}

}  // namespace

bool passes_through(const dvec3& from, const dvec3& to, const dvec3& a, const dvec3& b, const dvec3& c) noexcept {
  const double s = volume6(a, b, c, from), e = volume6(a, b, c, to);
  return s * e < 0 && passes_between(from, to, s, e, a, b, c);
}

bool cross_each_other(const Corners& a, const Corners& b) noexcept {
  int shared = 0, of_a = 0, of_b = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (a.v[i] == b.v[j]) ++shared, of_a = i, of_b = j;
    }
  }
  if (shared >= 2 || is_beside(a, b) || is_beside(b, a)) return false;
  // The volumes of each corner of one triangle and the whole other triangle are computed once and used for two edges.
  const auto volumes = [](const Corners& from, const Corners& t, double(&v)[3]) {
    for (int i = 0; i < 3; ++i) v[i] = volume6(t.p[0], t.p[1], t.p[2], from.p[i]);
  };
  double in_a[3], in_b[3];
  volumes(a, b, in_a), volumes(b, a, in_b);
  const auto edge = [](const Corners& from, int i, const double(&v)[3], const Corners& t) {
    const int k = (i + 1) % 3;
    return v[i] * v[k] < 0 && passes_between(from.p[i], from.p[k], v[i], v[k], t.p[0], t.p[1], t.p[2]);
  };
  if (shared == 1) return edge(a, (of_a + 1) % 3, in_a, b) || edge(b, (of_b + 1) % 3, in_b, a);
  for (int i = 0; i < 3; ++i) {
    if (edge(a, i, in_a, b) || edge(b, i, in_b, a)) return true;
  }
  return false;
}

}  // namespace typodont::haptics::mesh
