// Nearest points of segments, paths and triangles. Any thread; never allocates.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>
#include <limits>
#include <span>

namespace typodont {

/// Fraction of the way from a to b at which the segment a–b is nearest to p; 0 if a equals b.
template <class V>
auto nearest_fraction(const V& a, const V& b, const V& p) noexcept {
  using Real = typename V::value_type;
  const V ab = b - a;
  const Real square = glm::dot(ab, ab);
  return square > 0 ? std::clamp(glm::dot(p - a, ab) / square, Real(0), Real(1)) : Real(0);
}
/// Point of the segment a–b nearest to p.
template <class V>
V nearest_on_segment(const V& a, const V& b, const V& p) noexcept {
  return a + nearest_fraction(a, b, p) * (b - a);
}
template <class V>
auto distance_to_segment(const V& a, const V& b, const V& p) noexcept {
  return glm::length(p - a - nearest_fraction(a, b, p) * (b - a));
}
/// Distance of p from the line through the points of a path; infinite if there are none.
inline double distance_to_path(std::span<const glm::dvec3> path, const glm::dvec3& p) noexcept {
  if (path.size() == 1) return glm::length(p - path.front());
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < path.size(); ++i)
    least = std::min(least, distance_to_segment(path[i], path[i + 1], p));
  return least;
}

struct NearestOnTriangle {
  glm::dvec3 p;
  int feature;  // corner 0 to 2, edge 3 (a–b), 4 (b–c), 5 (c–a), interior 6
};
/// Point of a triangle nearest to p, from the triangle's Voronoi regions (Ericson 2005, Real-Time Collision Detection,
/// section 5.1.5).
inline NearestOnTriangle nearest_on_triangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                                             const glm::dvec3& p) noexcept {
  const glm::dvec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return {a, 0};
  const glm::dvec3 bp = p - b;
  const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return {b, 1};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + d1 / (d1 - d3) * ab, 3};
  const glm::dvec3 cp = p - c;
  const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return {c, 2};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + d2 / (d2 - d6) * ac, 5};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return {b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), 4};
  const double sum = va + vb + vc;
  if (!(std::abs(sum) > 0)) return {a, 0};
  return {a + vb / sum * ab + vc / sum * ac, 6};
}

}  // namespace typodont
