// Tree of boxes around triangles (BVH): finds nearest points and counts crossings of rays.
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
    std::size_t triangle = 0;  // index in the list that the constructor received
    glm::dvec3 point{0};
    double distance_squared = 0;
  };
  /// Nearest point on the mesh; nullopt if none is nearer than `reach`.
  std::optional<Nearest> nearest(const glm::dvec3& p, double reach) const;
  /// Squared distance to the mesh; reach² if nothing is nearer than `reach`.
  double distance_squared(const glm::dvec3& p, double reach = 1e150) const;
  /// Winding number: 1 inside, 0 outside, 2 in overlaps, negative in an inverted mesh. The median of three rays,
  /// because a ray through an edge can count wrongly.
  int winding(const glm::dvec3& p) const;
  /// Six times the winding number of a mesh that may be open (WindingNumbers in distance.h).
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
  /// Sum over the crossings of a ray: +1 where it leaves the mesh, −1 where it enters.
  int crossings(std::size_t index, const glm::dvec3& p, const glm::dvec3& direction, const glm::dvec3& inverse) const;

  std::vector<Triangle> triangles_;  // triangles in the order of the leaves
  std::vector<std::size_t> given_;   // for each triangle: its index in the list that the constructor received
  std::vector<Node> nodes_;
};

}  // namespace typodont::haptics::importing
