#include "haptics/import/mesh_solid.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "haptics/import/distance.h"
#include "haptics/import/mesh.h"

namespace typodont::haptics {

namespace {

using importing::Triangle;

/// Triangles in a tree of boxes, split at the median of the longest edge.
class MeshSolid : public Solid {
 public:
  explicit MeshSolid(const importing::Mesh& mesh) {
    for (const auto& c : mesh.corners) {
      const auto at = [&](std::size_t k) { return mesh.points[static_cast<std::size_t>(c[k])]; };
      triangles_.push_back({at(0), at(1), at(2)});
    }
    build(0, triangles_.size());
  }

  double distance(const dvec3& p) const override {
    double best2 = 1e300;
    nearest(0, p, best2);
    return is_inside(p) ? -std::sqrt(best2) : std::sqrt(best2);
  }
  void bounds(dvec3& lo, dvec3& hi) const override { lo = nodes_[0].lo, hi = nodes_[0].hi; }

 private:
  static constexpr std::size_t kLeaf = 4;
  struct Node {
    dvec3 lo{1e300}, hi{-1e300};
    std::size_t first = 0, count = 0;  // of triangles in a leaf …
    std::size_t left = 0, right = 0;   // … or children
  };

  static double distance2(const Node& node, const dvec3& p) {
    const dvec3 off = glm::max(glm::max(node.lo - p, p - node.hi), dvec3(0));
    return glm::dot(off, off);
  }

  std::size_t build(std::size_t first, std::size_t end) {
    const std::size_t index = nodes_.size();
    nodes_.emplace_back();
    Node node;
    for (std::size_t i = first; i < end; ++i) {
      const Triangle& t = triangles_[i];
      node.lo = glm::min(node.lo, glm::min(t.a, glm::min(t.b, t.c)));
      node.hi = glm::max(node.hi, glm::max(t.a, glm::max(t.b, t.c)));
    }
    if (end - first <= kLeaf) {
      node.first = first, node.count = end - first;
    } else {
      const dvec3 extent = node.hi - node.lo;
      const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
      const std::size_t middle = (first + end) / 2;
      const auto at = [&](std::size_t i) { return triangles_.begin() + static_cast<std::ptrdiff_t>(i); };
      std::nth_element(at(first), at(middle), at(end), [axis](const Triangle& s, const Triangle& t) {
        return s.a[axis] + s.b[axis] + s.c[axis] < t.a[axis] + t.b[axis] + t.c[axis];
      });
      node.left = build(first, middle);
      node.right = build(middle, end);
    }
    nodes_[index] = node;
    return index;
  }

  void nearest(std::size_t index, const dvec3& p, double& best2) const {
    const Node& node = nodes_[index];
    for (std::size_t i = node.first; i < node.first + node.count; ++i) {
      const dvec3 off = p - importing::closest_on(triangles_[i], p);
      best2 = std::min(best2, glm::dot(off, off));
    }
    if (node.count > 0) return;
    const double left = distance2(nodes_[node.left], p), right = distance2(nodes_[node.right], p);
    const bool left_first = left <= right;
    if (std::min(left, right) < best2) nearest(left_first ? node.left : node.right, p, best2);
    if (std::max(left, right) < best2) nearest(left_first ? node.right : node.left, p, best2);
  }

  /// By the parity of the triangles that a ray meets; of three rays, so that one through an edge is outvoted.
  bool is_inside(const dvec3& p) const {
    static const dvec3 kWays[3] = {glm::normalize(dvec3(0.5773, 0.2113, 0.7886)),
                                   glm::normalize(dvec3(-0.6142, 0.7361, 0.2847)),
                                   glm::normalize(dvec3(0.1931, -0.8253, 0.5306))};
    int votes = 0;
    for (int i = 0; i < 3; ++i) {
      votes += crossings(0, p, kWays[i], 1.0 / kWays[i]) % 2;
      if (votes == 2 || votes + 2 - i < 2) break;
    }
    return votes >= 2;
  }

  int crossings(std::size_t index, const dvec3& p, const dvec3& way, const dvec3& inverse) const {
    const Node& node = nodes_[index];
    const dvec3 a = (node.lo - p) * inverse, b = (node.hi - p) * inverse;
    const dvec3 in = glm::min(a, b), out = glm::max(a, b);
    if (std::max({in.x, in.y, in.z, 0.0}) > std::min({out.x, out.y, out.z})) return 0;
    if (node.count == 0) return crossings(node.left, p, way, inverse) + crossings(node.right, p, way, inverse);
    int count = 0;
    for (std::size_t i = node.first; i < node.first + node.count; ++i) {
      // Moeller & Trumbore 1997.
      const Triangle& t = triangles_[i];
      const dvec3 e1 = t.b - t.a, e2 = t.c - t.a, h = glm::cross(way, e2);
      const double det = glm::dot(e1, h);
      if (!(std::abs(det) > 0)) continue;
      const dvec3 s = p - t.a, q = glm::cross(s, e1);
      const double u = glm::dot(s, h) / det, v = glm::dot(way, q) / det;
      count += u >= 0 && v >= 0 && u + v <= 1 && glm::dot(e2, q) / det > 0;
    }
    return count;
  }

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace

std::unique_ptr<Solid> read_mesh_solid(const std::filesystem::path& file, double unit) {
  return std::make_unique<MeshSolid>(importing::read_mesh(file, unit));
}

}  // namespace typodont::haptics
