// A tree of boxes over triangles. It finds the nearest triangle and counts the crossings of rays.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "haptics/import/distance.h"

namespace typodont::haptics::importing {

class TriangleTree {
 public:
  explicit TriangleTree(std::vector<Triangle> triangles);

  struct Nearest {
    std::size_t triangle = 0;  // index of the triangle in the list that the constructor received
    glm::dvec3 point{0};
    double distance_squared = 0;
  };
  /// Returns the nearest point of the triangles, or no value if its distance is `reach` or more.
  std::optional<Nearest> nearest(const glm::dvec3& p, double reach) const;
  /// Returns the squared distance from p to the nearest triangle, which must be nearer than `reach`.
  double distance_squared(const glm::dvec3& p, double reach = 1e150) const;
  /// Returns the winding number of a closed mesh at p: 1 inside, 0 outside, 2 where two parts overlap, negative where
  /// the triangles face inward. It is the median of the winding numbers of three rays. So one ray that hits an edge of
  /// the mesh does not change the result.
  int winding(const glm::dvec3& p) const;
  /// Returns six times the winding number of a mesh at p, which may be open. It is computed from rays in the six axis
  /// directions. See WindingNumbers in distance.h.
  int winding_sixths(const glm::dvec3& p) const;

  const glm::dvec3& lo() const { return nodes_[0].lo; }
  const glm::dvec3& hi() const { return nodes_[0].hi; }

 private:
  static constexpr std::size_t kLeaf = 4;
  struct Node {
    glm::dvec3 lo{1e300}, hi{-1e300};
    std::size_t first = 0, count = 0;  // range of the triangles of a leaf
    std::size_t left = 0, right = 0;   // indices of the children of an inner node
  };

  std::size_t build(std::size_t first, std::size_t end);
  void nearest(std::size_t index, const glm::dvec3& p, Nearest& best) const;
  /// Returns the sum of the crossings of a ray with the mesh: +1 where the ray leaves the mesh, −1 where it enters the
  /// mesh.
  int crossings(std::size_t index, const glm::dvec3& p, const glm::dvec3& way, const glm::dvec3& inverse) const;

  std::vector<Triangle> triangles_;  // triangles in the order of the leaves
  std::vector<std::size_t> given_;   // for each triangle: its index in the list that the constructor received
  std::vector<Node> nodes_;
};

}  // namespace typodont::haptics::importing
