// A contact method for comparison in benchmark rows: a point proxy on a mesh that was enlarged by the head's radius,
// with force shading. Programs based on CHAI3D use this method for a ball.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "haptics/contact/mesh_lod/triangle_grid.h"

namespace typodont::haptics::bench {

class OffsetMesh {
 public:
  /// Makes a ball at the origin: starts with an icosahedron, and divides each triangle into four. This division is
  /// repeated `subdivisions` times. Call only at set-up.
  OffsetMesh(double radius, int subdivisions);
  std::size_t triangles() const { return grid_.size(); }

  /// Sets the position of the proxy, which must be outside the mesh.
  void place(const dvec3& p) { proxy_ = p; }
  /// Computes one tick: moves the proxy along the surface to the point nearest to `goal` (Zilles & Salisbury 1995).
  /// Returns the direction of the force, interpolated from the normals of the vertices (Morgenbesser & Srinivasan
  /// 1996). The direction is zero without contact.
  dvec3 follow(const dvec3& goal) noexcept;

 private:
  struct Hit {
    std::uint32_t face;
    double part;  // position of the hit as a fraction of the segment
    double u, v;  // barycentric weights of the face's second and third corner at the hit
  };
  std::optional<Hit> first_hit(const dvec3& from, const dvec3& to) const noexcept;

  mesh_lod::TriangleGrid grid_;
  std::vector<glm::uvec3> corners_;  // for each face: the indices of its three vertices
  std::vector<dvec3> normals_;       // unit normal at each vertex
  dvec3 proxy_{0};
};

}  // namespace typodont::haptics::bench
