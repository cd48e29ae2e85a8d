// A point proxy on a mesh that was offset beforehand by the head's radius, with force shading. Programs based on
// CHAI3D use this method for a ball. Only a reference for bench rows.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "haptics/contact/mesh_lod/triangle_grid.h"

namespace typodont::haptics::bench {

class OffsetMesh {
 public:
  /// Makes a ball at the origin: an icosahedron whose triangles are quartered `subdivisions` times. Set-up time.
  OffsetMesh(double radius, int subdivisions);
  std::size_t triangles() const { return grid_.size(); }

  /// Places the proxy, which must be outside.
  void place(const dvec3& p) { proxy_ = p; }
  /// One tick: moves the proxy to the point nearest to `goal` that it can reach along the surface (Zilles & Salisbury
  /// 1995). Returns the force's direction, interpolated from the vertices' normals (Morgenbesser & Srinivasan 1996);
  /// zero without contact.
  dvec3 follow(const dvec3& goal) noexcept;

 private:
  struct Hit {
    std::uint32_t face;
    double part;  // fraction of the segment
    double u, v;  // weights of the face's second and third corner
  };
  std::optional<Hit> first_hit(const dvec3& from, const dvec3& to) const noexcept;

  mesh_lod::TriangleGrid grid_;
  std::vector<glm::uvec3> corners_;  // corners of each face
  std::vector<dvec3> normals_;       // unit normal at each vertex
  dvec3 proxy_{0};
};

}  // namespace typodont::haptics::bench
