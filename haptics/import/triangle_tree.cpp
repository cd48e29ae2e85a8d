#include "haptics/import/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/base/nearest.h"

namespace typodont::haptics::importing {

using glm::dvec3;

TriangleTree::TriangleTree(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
  given_.resize(triangles_.size());
  std::iota(given_.begin(), given_.end(), std::size_t{0});
  build(0, triangles_.size());
  std::vector<Triangle> in_leaves;
  in_leaves.reserve(triangles_.size());
  for (const std::size_t i : given_) in_leaves.push_back(triangles_[i]);
  triangles_ = std::move(in_leaves);
}

static double distance2(const dvec3& lo, const dvec3& hi, const dvec3& p) {
  const dvec3 off = glm::max(glm::max(lo - p, p - hi), dvec3(0));
  return glm::dot(off, off);
}

// Builds a node; divides its triangles into two halves along the longest edge of their box.
std::size_t TriangleTree::build(std::size_t first, std::size_t end) {
  const std::size_t index = nodes_.size();
  nodes_.emplace_back();
  Node node;
  for (std::size_t i = first; i < end; ++i) {
    const Triangle& t = triangles_[given_[i]];
    node.lo = glm::min(node.lo, glm::min(t.a, glm::min(t.b, t.c)));
    node.hi = glm::max(node.hi, glm::max(t.a, glm::max(t.b, t.c)));
  }
  if (end - first <= kLeaf) {
    node.first = first, node.count = end - first;
  } else {
    const dvec3 extent = node.hi - node.lo;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const std::size_t middle = (first + end) / 2;
    const auto at = [&](std::size_t i) { return given_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(first), at(middle), at(end), [&, axis](std::size_t i, std::size_t k) {
      const Triangle &s = triangles_[i], &t = triangles_[k];
      return s.a[axis] + s.b[axis] + s.c[axis] < t.a[axis] + t.b[axis] + t.c[axis];
    });
    node.left = build(first, middle);
    node.right = build(middle, end);
  }
  nodes_[index] = node;
  return index;
}

double TriangleTree::distance_squared(const dvec3& p, double reach) const {
  Nearest best{.distance_squared = reach * reach};
  nearest(0, p, best);
  return best.distance_squared;
}

std::optional<TriangleTree::Nearest> TriangleTree::nearest(const dvec3& p, double reach) const {
  Nearest best{.distance_squared = reach * reach};
  if (distance2(lo(), hi(), p) >= best.distance_squared) return std::nullopt;
  nearest(0, p, best);
  if (!(best.distance_squared < reach * reach)) return std::nullopt;
  best.triangle = given_[best.triangle];
  return best;
}

void TriangleTree::nearest(std::size_t index, const dvec3& p, Nearest& best) const {
  const Node& node = nodes_[index];
  for (std::size_t i = node.first; i < node.first + node.count; ++i) {
    const Triangle& t = triangles_[i];
    const dvec3 c = nearest_on_triangle(t.a, t.b, t.c, p).p, off = p - c;
    if (const double d2 = glm::dot(off, off); d2 < best.distance_squared) best = {i, c, d2};
  }
  if (node.count > 0) return;
  const Node &l = nodes_[node.left], &r = nodes_[node.right];
  const double left = distance2(l.lo, l.hi, p), right = distance2(r.lo, r.hi, p);
  const bool left_first = left <= right;
  if (std::min(left, right) < best.distance_squared) nearest(left_first ? node.left : node.right, p, best);
  if (std::max(left, right) < best.distance_squared) nearest(left_first ? node.right : node.left, p, best);
}

int TriangleTree::winding(const dvec3& p) const {
  static const dvec3 kWays[3] = {glm::normalize(dvec3(0.5773, 0.2113, 0.7886)),
                                 glm::normalize(dvec3(-0.6142, 0.7361, 0.2847)),
                                 glm::normalize(dvec3(0.1931, -0.8253, 0.5306))};
  const auto turns = [&](const dvec3& direction) { return crossings(0, p, direction, 1.0 / direction); };
  // Returns the winding number on which two of the three rays agree, otherwise the median.
  const int first = turns(kWays[0]), second = turns(kWays[1]);
  return first == second ? first : std::clamp(turns(kWays[2]), std::min(first, second), std::max(first, second));
}

int TriangleTree::winding_sixths(const dvec3& p) const {
  // The rays are tilted slightly, so that none lies in a face of the mesh.
  constexpr double kTilt = 1.618e-7, kOtherTilt = 2.718e-7;
  int sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {1.0, -1.0}) {
      dvec3 direction;
      direction[axis] = side, direction[(axis + 1) % 3] = kTilt, direction[(axis + 2) % 3] = kOtherTilt;
      sum += crossings(0, p, direction, 1.0 / direction);
    }
  }
  return sum;
}

int TriangleTree::crossings(std::size_t index, const dvec3& p, const dvec3& direction, const dvec3& inverse) const {
  const Node& node = nodes_[index];
  const dvec3 a = (node.lo - p) * inverse, b = (node.hi - p) * inverse;
  const dvec3 in = glm::min(a, b), out = glm::max(a, b);
  if (std::max({in.x, in.y, in.z, 0.0}) > std::min({out.x, out.y, out.z})) return 0;
  if (node.count == 0)
    return crossings(node.left, p, direction, inverse) + crossings(node.right, p, direction, inverse);
  int sum = 0;
  for (std::size_t i = node.first; i < node.first + node.count; ++i) {
    // Intersection of ray and triangle, Moeller & Trumbore 1997.
    const Triangle& t = triangles_[i];
    const dvec3 e1 = t.b - t.a, e2 = t.c - t.a, h = glm::cross(direction, e2);
    const double det = glm::dot(e1, h);
    if (!(std::abs(det) > 0)) continue;
    const dvec3 s = p - t.a, q = glm::cross(s, e1);
    const double u = glm::dot(s, h) / det, v = glm::dot(direction, q) / det;
    // det < 0: the ray leaves the mesh.
    if (u >= 0 && v >= 0 && u + v <= 1 && glm::dot(e2, q) / det > 0) sum += det < 0 ? 1 : -1;
  }
  return sum;
}

}  // namespace typodont::haptics::importing
