// A baseline: a point proxy on the mesh of a ball that was enlarged by the head's radius, with force shading. Programs
// based on CHAI3D use this method for a round head.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "haptics/contact/mesh_lod/triangle_grid.h"
#include "tests/support/mesh_shapes.h"

namespace typodont::bench {

class OffsetMesh {
 public:
  OffsetMesh(double radius, double edge) {
    const haptics::TissueMesh mesh = test::ball(dvec3(radius), edge);
    grid_ = haptics::mesh_lod::TriangleGrid(mesh);
    for (const dvec3& p : mesh.vertices) normals_.push_back(glm::normalize(p));
    corners_ = mesh.triangles;
  }
  /// Sets the position of the proxy, which must be outside the mesh.
  void place(const dvec3& p) { proxy_ = p; }

  /// Moves the proxy along the surface to the point nearest to `goal` (Zilles & Salisbury 1995). Returns the direction
  /// of the force, interpolated from the normals of the vertices (Morgenbesser & Srinivasan 1996).
  dvec3 follow(const dvec3& goal) noexcept {
    constexpr double kLift = 1e-8;  // m, height of the proxy above the face that stops it
    dvec3 target = goal, shaded(0), n[3];
    for (int planes = 0; planes < 3; ++planes) {
      const std::optional<Hit> hit = first_hit(proxy_, target);
      if (!hit) {
        proxy_ = target;
        break;
      }
      n[planes] = glm::normalize(grid_.face(hit->face).normal());
      proxy_ += hit->part * (target - proxy_) + kLift * n[planes];
      const glm::uvec3& corner = corners_[hit->face];
      shaded = glm::normalize((1 - hit->u - hit->v) * normals_[corner.x] + hit->u * normals_[corner.y] +
                              hit->v * normals_[corner.z]);
      // The rest of the motion lies in the first plane, or on the edge of the first two planes.
      const dvec3 rest = goal - proxy_;
      if (planes == 0) {
        target = proxy_ + rest - glm::dot(rest, n[0]) * n[0];
      } else if (const dvec3 edge = glm::cross(n[0], n[1]); planes == 1 && glm::dot(edge, edge) > 0) {
        target = proxy_ + glm::dot(rest, edge) / glm::dot(edge, edge) * edge;
      }
    }
    return shaded;
  }

 private:
  struct Hit {
    std::uint32_t face;
    double part;  // position of the hit as a fraction of the segment
    double u, v;  // barycentric weights of the face's second and third corner
  };
  /// Returns the first face that the segment enters from outside (Möller & Trumbore 1997).
  std::optional<Hit> first_hit(const dvec3& from, const dvec3& to) const noexcept {
    const dvec3 way = to - from;
    std::optional<Hit> first;
    grid_.for_near(glm::min(from, to), glm::max(from, to), [&](std::uint32_t i) {
      const haptics::mesh_lod::Face& face = grid_.face(i);
      const dvec3 e = face.b - face.a, f = face.c - face.a, across = glm::cross(way, f);
      const double det = glm::dot(e, across);
      if (!(det > 0)) return;  // parallel, or from inside to outside
      const dvec3 off = from - face.a, around = glm::cross(off, e);
      const double u = glm::dot(off, across) / det, v = glm::dot(way, around) / det, part = glm::dot(f, around) / det;
      if (u < 0 || u > 1 || v < 0 || u + v > 1 || part < 0 || part > 1 || (first && first->part <= part)) return;
      first = {i, part, u, v};
    });
    return first;
  }

  haptics::mesh_lod::TriangleGrid grid_;
  std::vector<glm::uvec3> corners_;  // for each face: the indices of its vertices
  std::vector<dvec3> normals_;       // unit normal at each vertex
  dvec3 proxy_{0};
};

}  // namespace typodont::bench
