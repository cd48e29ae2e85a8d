// A point proxy on a mesh that was offset by the head's radius beforehand, with force shading: what CHAI3D's users have
// for a ball. Only a yardstick for bench rows.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "haptics/contact/mesh_lod/triangle_grid.h"

namespace typodont::haptics::bench {

class OffsetMesh {
 public:
  /// A ball at the origin: an icosahedron whose triangles are quartered `subdivisions` times. Set-up.
  OffsetMesh(double radius, int subdivisions);
  std::size_t triangles() const { return grid_.size(); }

  /// The proxy starts here, outside.
  void place(const dvec3& p) { proxy_ = p; }
  /// One tick: moves the proxy to the point nearest to `goal` that it reaches along the surface (Zilles & Salisbury
  /// 1995), and returns the force's direction: the vertices' normals, interpolated (Morgenbesser & Srinivasan 1996).
  /// Zero without contact.
  dvec3 follow(const dvec3& goal) noexcept;

 private:
  struct Hit {
    std::uint32_t face;
    double part;  // of the segment
    double u, v;  // weights of the face's second and third corner
  };
  std::optional<Hit> first_hit(const dvec3& from, const dvec3& to) const noexcept;

  mesh_lod::TriangleGrid grid_;
  std::vector<glm::uvec3> corners_;  // of each face
  std::vector<dvec3> normals_;       // of each vertex, unit
  dvec3 proxy_{0};
};

}  // namespace typodont::haptics::bench
