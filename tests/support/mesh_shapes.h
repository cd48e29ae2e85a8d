// Meshes of known shape, and brute-force checks for any mesh.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/fnv.h"
#include "engine/base/units.h"
#include "haptics/mesh/crossing.h"
#include "haptics/mesh/editable_mesh.h"

namespace typodont::test {

/// Hash of the points, faces and tissues in use.
inline std::uint64_t mesh_hash(const haptics::mesh::EditableMesh& mesh) {
  Fnv1a hash;
  for (haptics::mesh::Index v = 0; v < mesh.vertex_range(); ++v) {
    if (mesh.vertex(v).face == haptics::mesh::kNone) continue;
    hash.add(v);
    for (int a = 0; a < 3; ++a) hash.add(mesh.vertex(v).p[a]);
  }
  for (haptics::mesh::Index f = 0; f < mesh.face_range(); ++f) {
    if (!mesh.uses(f)) continue;
    hash.add(f);
    for (const haptics::mesh::Index v : mesh.face(f).v) hash.add(v);
    hash.add(static_cast<std::uint8_t>(mesh.face(f).tissue));
  }
  return hash.value;
}

/// Returns a square about the origin in the plane z = 0, facing up. Rows are shifted by half an edge, so that the
/// triangles are nearly equilateral.
inline haptics::TissueMesh square(double size, double edge, Tissue tissue = Tissue::kEnamel) {
  haptics::TissueMesh mesh;
  const int n = static_cast<int>(std::ceil(size / edge));
  const double h = size / n;
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) {
      const double shift = (y % 2 && x > 0 && x < n) ? 0.5 * h : 0.0;
      mesh.vertices.emplace_back(x * h - size / 2 + shift, y * h - size / 2, 0);
    }
  }
  const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * (n + 1) + x); };
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const bool odd = y % 2;
      if (odd) {
        mesh.triangles.emplace_back(at(x, y), at(x + 1, y), at(x + 1, y + 1));
        mesh.triangles.emplace_back(at(x, y), at(x + 1, y + 1), at(x, y + 1));
      } else {
        mesh.triangles.emplace_back(at(x, y), at(x + 1, y), at(x, y + 1));
        mesh.triangles.emplace_back(at(x + 1, y), at(x + 1, y + 1), at(x, y + 1));
      }
    }
  }
  mesh.tissue.assign(mesh.triangles.size(), tissue);
  return mesh;
}

/// Returns a closed ball or ellipsoid about `center` with half axes `half`. It is an octahedron whose triangles are
/// divided until their edges are at most `edge` long.
inline haptics::TissueMesh ball(const dvec3& half, double edge, const dvec3& center = dvec3(0),
                                Tissue tissue = Tissue::kEnamel) {
  std::vector<dvec3> v{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<glm::uvec3> t{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  double longest = std::sqrt(2.0) * std::max({half.x, half.y, half.z});
  while (longest > edge) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
    const auto between = [&](std::uint32_t a, std::uint32_t b) {
      const auto [found, fresh] = middle.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(v.size()));
      if (fresh) v.push_back(glm::normalize(v[a] + v[b]));
      return found->second;
    };
    std::vector<glm::uvec3> finer;
    for (const glm::uvec3& f : t) {
      const std::uint32_t a = between(f.x, f.y), b = between(f.y, f.z), c = between(f.z, f.x);
      for (const glm::uvec3& g :
           {glm::uvec3(f.x, a, c), glm::uvec3(a, f.y, b), glm::uvec3(c, b, f.z), glm::uvec3(a, b, c)}) {
        finer.push_back(g);
      }
    }
    t = std::move(finer);
    longest /= 1.8;
  }
  haptics::TissueMesh mesh;
  for (const dvec3& p : v) mesh.vertices.push_back(center + half * p);
  mesh.triangles = std::move(t);
  mesh.tissue.assign(mesh.triangles.size(), tissue);
  return mesh;
}

/// Makes `count` random edits: splits, flips, collapses, changes of tissue, small and large moves.
inline void random_edits(haptics::mesh::EditableMesh& mesh, std::mt19937& random, int count) {
  for (int k = 0; k < count; ++k) {
    const auto f = static_cast<haptics::mesh::Index>(random() % mesh.face_range());
    const int i = static_cast<int>(random() % 3);
    const auto what = random() % 6;
    if (!mesh.uses(f)) continue;
    if (what == 0) mesh.split(f, i, 0.5 * (mesh.point(f, i) + mesh.point(f, (i + 1) % 3)));
    if (what == 1) mesh.flip(f, i);
    if (what == 2) mesh.collapse(f, i, random() % 2);
    if (what == 3) mesh.set_tissue(f, random() % 2 ? Tissue::kDentin : Tissue::kEnamel);
    if (what >= 4) {
      const haptics::mesh::Index v = mesh.face(f).v[i];
      mesh.move(v, mesh.vertex(v).p + (what == 4 ? 1e-5 : 1e-4) * dvec3(random() % 7, random() % 5, random() % 3));
      mesh.settle(v);
    }
  }
}

/// Returns the volume (m³) between the faces and the origin. For a closed mesh this is its volume.
inline double volume(const haptics::mesh::EditableMesh& mesh) {
  double sum = 0;
  for (haptics::mesh::Index f = 0; f < mesh.face_range(); ++f) {
    if (mesh.uses(f)) sum += glm::dot(mesh.point(f, 0), glm::cross(mesh.point(f, 1), mesh.point(f, 2))) / 6;
  }
  return sum;
}

/// Checks the neighbour links. Returns an empty text if they are correct: every edge of a face links to the face beyond
/// it, every vertex links to one of its faces, and the counts are right.
inline std::string broken(const haptics::mesh::EditableMesh& mesh) {
  using haptics::mesh::Index;
  using haptics::mesh::kNone;
  std::size_t faces = 0, vertices = 0, corners = 0;
  for (Index f = 0; f < mesh.face_range(); ++f) {
    if (!mesh.uses(f)) continue;
    ++faces;
    for (int i = 0; i < 3; ++i) {
      const Index a = mesh.face(f).v[i], b = mesh.face(f).v[(i + 1) % 3], g = mesh.face(f).n[i];
      if (a == b || mesh.vertex(a).face == kNone) return "a face names a vertex that is not in use, or one twice";
      if (g == kNone) continue;
      if (!mesh.uses(g)) return "a neighbour is not in use";
      const int j = mesh.edge_to(g, f, b);
      if (mesh.face(g).n[j] != f || mesh.face(g).v[j] != b || mesh.face(g).v[(j + 1) % 3] != a) {
        return "a neighbour does not agree";
      }
    }
  }
  for (Index v = 0; v < mesh.vertex_range(); ++v) {
    if (mesh.vertex(v).face == kNone) continue;
    ++vertices;
    if (!mesh.uses(mesh.vertex(v).face)) return "a vertex names a face that is not in use";
    mesh.around(v, [&](Index f, int c) { corners += mesh.face(f).v[c] == v; });
  }
  if (faces != mesh.face_count() || vertices != mesh.vertex_count()) return "the counts are wrong";
  if (corners != 3 * faces) return "around() misses faces";
  return "";
}

/// Returns the number of pairs of intersecting faces. Tests every face against all faces near it.
inline int crossings(const haptics::mesh::EditableMesh& mesh) {
  using haptics::mesh::Index;
  std::vector<std::pair<double, Index>> by_x;
  std::vector<dvec3> lo(mesh.face_range()), hi(mesh.face_range());
  for (Index f = 0; f < mesh.face_range(); ++f) {
    if (!mesh.uses(f)) continue;
    const haptics::mesh::Corners t = haptics::mesh::corners(mesh, f);
    lo[f] = glm::min(glm::min(t.p[0], t.p[1]), t.p[2]), hi[f] = glm::max(glm::max(t.p[0], t.p[1]), t.p[2]);
    by_x.emplace_back(lo[f].x, f);
  }
  std::sort(by_x.begin(), by_x.end());
  int count = 0;
  for (std::size_t i = 0; i < by_x.size(); ++i) {
    const Index f = by_x[i].second;
    const haptics::mesh::Corners t = haptics::mesh::corners(mesh, f);
    for (std::size_t k = i + 1; k < by_x.size() && by_x[k].first <= hi[f].x; ++k) {
      const Index g = by_x[k].second;
      if (glm::any(glm::lessThan(hi[g], lo[f])) || glm::any(glm::lessThan(hi[f], lo[g]))) continue;
      count += haptics::mesh::cross_each_other(t, haptics::mesh::corners(mesh, g));
    }
  }
  return count;
}

}  // namespace typodont::test
