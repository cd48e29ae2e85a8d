// Boxes over triangles: nearest point, crossings of rays.
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
    std::size_t triangle = 0;  // in the constructor's list
    glm::dvec3 point{0};
    double distance_squared = 0;
  };
  /// Empty at `reach` or more.
  std::optional<Nearest> nearest(const glm::dvec3& p, double reach) const;
  /// Nearer than `reach`.
  double distance_squared(const glm::dvec3& p, double reach = 1e150) const;
  /// 1 inside, 0 outside, 2 in overlaps, negative if inverted: median of three rays, safe against an edge.
  int winding(const glm::dvec3& p) const;
  /// Six times that of a possibly open mesh (WindingNumbers in distance.h).
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
  /// +1 leaves, −1 enters.
  int crossings(std::size_t index, const glm::dvec3& p, const glm::dvec3& way, const glm::dvec3& inverse) const;

  std::vector<Triangle> triangles_;  // triangles in the order of the leaves
  std::vector<std::size_t> given_;   // for each triangle: its index in the list that the constructor received
  std::vector<Node> nodes_;
};

}  // namespace typodont::haptics::importing
