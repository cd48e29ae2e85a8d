#include "haptics/bench/offset_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace typodont::haptics::bench {

namespace {

TissueMesh icosphere(double radius, int subdivisions) {
  const double t = (1 + std::sqrt(5.0)) / 2;
  TissueMesh mesh;
  for (const dvec3& p :
       {dvec3(-1, t, 0), dvec3(1, t, 0), dvec3(-1, -t, 0), dvec3(1, -t, 0), dvec3(0, -1, t), dvec3(0, 1, t),
        dvec3(0, -1, -t), dvec3(0, 1, -t), dvec3(t, 0, -1), dvec3(t, 0, 1), dvec3(-t, 0, -1), dvec3(-t, 0, 1)}) {
    mesh.vertices.push_back(radius * glm::normalize(p));
  }
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int i = 0; i < subdivisions; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, fresh] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.vertices.size()));
      if (fresh) mesh.vertices.push_back(radius * glm::normalize(mesh.vertices[a] + mesh.vertices[b]));
      return it->second;
    };
    std::vector<glm::uvec3> quarters;
    for (const glm::uvec3& f : mesh.triangles) {
      const std::uint32_t a = middle(f.x, f.y), b = middle(f.y, f.z), c = middle(f.z, f.x);
      quarters.insert(quarters.end(), {{f.x, a, c}, {f.y, b, a}, {f.z, c, b}, {a, b, c}});
    }
    mesh.triangles = std::move(quarters);
  }
  mesh.tissue.assign(mesh.triangles.size(), Tissue::kDentin);
  return mesh;
}

}  // namespace

OffsetMesh::OffsetMesh(double radius, int subdivisions) {
  TissueMesh mesh = icosphere(radius, subdivisions);
  grid_ = mesh_lod::TriangleGrid(mesh);
  for (const dvec3& p : mesh.vertices) normals_.push_back(glm::normalize(p));
  corners_ = std::move(mesh.triangles);
}

/// Returns the first face that the segment enters from outside (Möller & Trumbore 1997).
std::optional<OffsetMesh::Hit> OffsetMesh::first_hit(const dvec3& from, const dvec3& to) const noexcept {
  const dvec3 way = to - from;
  std::optional<Hit> first;
  grid_.for_near(glm::min(from, to), glm::max(from, to), [&](std::uint32_t i) {
    const mesh_lod::Face& face = grid_.face(i);
    const dvec3 e = face.b - face.a, f = face.c - face.a, across = glm::cross(way, f);
    const double det = glm::dot(e, across);
    if (!(det > 0)) return;  // the segment is parallel to the face, or crosses it from inside to outside
    const dvec3 off = from - face.a;
    const double u = glm::dot(off, across) / det;
    if (u < 0 || u > 1) return;
    const dvec3 around = glm::cross(off, e);
    const double v = glm::dot(way, around) / det, part = glm::dot(f, around) / det;
    if (v < 0 || u + v > 1 || part < 0 || part > 1 || (first && first->part <= part)) return;
    first = {i, part, u, v};
  });
  return first;
}

dvec3 OffsetMesh::follow(const dvec3& goal) noexcept {
  constexpr int kMostPlanes = 3;
  constexpr double kLift = 1e-8;  // m, height of the proxy above the face that stops it
  dvec3 target = goal, shaded(0), n[kMostPlanes];
  for (int planes = 0; planes < kMostPlanes; ++planes) {
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
    // Computes which part of the remaining motion is allowed by the planes that were found so far. With one plane it is
    // a motion in the plane, and with two planes a motion along their common edge. With three planes there is no
    // motion.
    const dvec3 rest = goal - proxy_;
    if (planes == 0) {
      target = proxy_ + rest - glm::dot(rest, n[0]) * n[0];
    } else if (const dvec3 edge = glm::cross(n[0], n[1]); planes == 1 && glm::dot(edge, edge) > 0) {
      target = proxy_ + glm::dot(rest, edge) / glm::dot(edge, edge) * edge;
    }
  }
  return shaded;
}

}  // namespace typodont::haptics::bench
