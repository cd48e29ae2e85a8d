// A tree of boxes over triangles: the nearest one, and how often rays cross them.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "haptics/import/distance.h"

namespace typodont::haptics::importing {

class TriangleTree {
 public:
  explicit TriangleTree(std::vector<Triangle> triangles);

  /// Squared distance to the nearest triangle.
  double distance_squared(const glm::dvec3& p) const;
  /// How often a closed mesh winds around p: 1 inside, 0 outside, 2 where two parts overlap, negative where the
  /// triangles face inwards. By the median of three rays, so that one through an edge is outvoted.
  int winding(const glm::dvec3& p) const;
  /// The same for open meshes, in sixths, by rays along the six directions of the axes; see winding_sixths() in
  /// distance.h.
  int winding_sixths(const glm::dvec3& p) const;

  const glm::dvec3& lo() const { return nodes_[0].lo; }
  const glm::dvec3& hi() const { return nodes_[0].hi; }

 private:
  static constexpr std::size_t kLeaf = 4;
  struct Node {
    glm::dvec3 lo{1e300}, hi{-1e300};
    std::size_t first = 0, count = 0;  // of triangles in a leaf …
    std::size_t left = 0, right = 0;   // … or children
  };

  std::size_t build(std::size_t first, std::size_t end);
  void nearest(std::size_t index, const glm::dvec3& p, double& best2) const;
  /// Crossings of a ray, +1 where it leaves the mesh and −1 where it enters it.
  int crossings(std::size_t index, const glm::dvec3& p, const glm::dvec3& way, const glm::dvec3& inverse) const;

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace typodont::haptics::importing
