#include "tests/support/surface_checks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "engine/base/fnv.h"
#include "engine/base/voxels.h"

namespace typodont::test {

FieldBrick sample_brick(const glm::ivec3& key, const Field& field, const Labels& labels, double band) {
  FieldBrick brick;
  brick.key = key;
  for_each_voxel(glm::ivec3(FieldBrick::kSamples), [&](int x, int y, int z) {
    const glm::dvec3 p = glm::dvec3(16 * key - 1 + glm::ivec3(x, y, z));
    const auto at = FieldBrick::at(x, y, z);
    brick.distance[at] = static_cast<float>(std::clamp(field(p), -band, band));
    brick.tissue[at] = labels ? labels(p) : Tissue::kEnamel;
  });
  return brick;
}

bool has_surface(const FieldBrick& brick) {
  bool solid = false, air = false;
  for_each_voxel_between(glm::ivec3(1), glm::ivec3(17), [&](int x, int y, int z) {
    (brick.distance[FieldBrick::at(x, y, z)] < 0 ? solid : air) = true;
  });
  return solid && air;
}

std::vector<FieldBrick> sample_bricks(const glm::dvec3& low, const glm::dvec3& high, const Field& field,
                                      const Labels& labels, double band) {
  std::vector<FieldBrick> bricks;
  const glm::ivec3 first = glm::ivec3(glm::floor(low / 16.0)), last = glm::ivec3(glm::floor(high / 16.0));
  for_each_voxel_between(first, last, [&](int x, int y, int z) {
    FieldBrick brick = sample_brick({x, y, z}, field, labels, band);
    if (has_surface(brick)) bricks.push_back(brick);
  });
  return bricks;
}

std::uint64_t mesh_hash(const surface::SurfaceMesher& mesher) {
  Fnv1a hash;
  for (const glm::ivec3& key : mesher.keys()) {
    const surface::BrickMesh& mesh = *mesher.find(key);
    for (int a = 0; a < 3; ++a) hash.add(key[a]);
    for (const surface::SurfaceVertex& v : mesh.vertices) {
      for (int a = 0; a < 3; ++a) hash.add(v.position[a]), hash.add(v.normal[a]);
      for (const Tissue tissue : v.tissue) hash.add(static_cast<std::uint8_t>(tissue));
      hash.add(v.second);
    }
    for (const std::uint32_t index : mesh.indices) hash.add(index);
  }
  return hash.value;
}

surface::SurfaceMesher mesh_of(const std::vector<FieldBrick>& bricks, float tolerance) {
  surface::SurfaceMesher mesher({.tolerance = tolerance});
  for (const FieldBrick& brick : bricks) mesher.put(brick);
  mesher.remesh();
  return mesher;
}

Topology topology_of(const surface::WholeMesh& mesh) {
  Topology t;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
  std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> link(mesh.vertices.size());
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0u);
  auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  t.closed = t.oriented = t.manifold = true;
  auto complain = [&t](bool& what, const std::string& text) {
    what = false;
    if (t.complaint.empty()) t.complaint = text;
  };
  for (const auto& tri : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = tri[i], b = tri[(i + 1) % 3], c = tri[(i + 2) % 3];
      if (a == b) complain(t.manifold, "triangle with a repeated corner");
      ++directed[{a, b}];
      link[a].push_back({b, c});
      parent[root(a)] = root(b);
    }
    const auto &p = mesh.vertices[tri[0]].position, &q = mesh.vertices[tri[1]].position,
               &r = mesh.vertices[tri[2]].position;
    t.volume += glm::dot(glm::dvec3(p), glm::cross(glm::dvec3(q), glm::dvec3(r))) / 6;
  }
  std::size_t edges = 0;
  for (const auto& [edge, count] : directed) {
    const auto back = directed.find({edge.second, edge.first});
    const int reverse = back == directed.end() ? 0 : back->second;
    if (edge.first < edge.second || reverse == 0) ++edges;
    if (count + reverse != 2) {
      const auto p = mesh.vertices[edge.first].position;
      complain(t.closed, "edge with " + std::to_string(count + reverse) + " triangles near " + std::to_string(p.x) +
                             " " + std::to_string(p.y) + " " + std::to_string(p.z));
    }
    if (count != 1 || reverse != 1) complain(t.oriented, "triangles of an edge run the same way");
  }
  std::size_t used = 0;
  for (std::size_t v = 0; v < link.size(); ++v) {
    if (link[v].empty()) continue;
    ++used;
    std::map<std::uint32_t, std::uint32_t> next(link[v].begin(), link[v].end());
    std::uint32_t at = link[v][0].first;
    std::size_t steps = 0;
    do {
      const auto it = next.find(at);
      if (it == next.end()) break;
      at = it->second;
      ++steps;
    } while (at != link[v][0].first && steps <= link[v].size());
    if (steps != link[v].size()) complain(t.manifold, "vertex with more than one fan");
  }
  std::set<std::uint32_t> roots;
  for (std::uint32_t v = 0; v < link.size(); ++v) {
    if (!link[v].empty()) roots.insert(root(v));
  }
  t.components = static_cast<int>(roots.size());
  t.euler = static_cast<long>(used) - static_cast<long>(edges) + static_cast<long>(mesh.triangles.size());
  return t;
}

double max_error(const surface::WholeMesh& mesh, const Field& distance, int n) {
  double worst = 0;
  for (const auto& tri : mesh.triangles) {
    const glm::dvec3 a = mesh.vertices[tri[0]].position, b = mesh.vertices[tri[1]].position,
                     c = mesh.vertices[tri[2]].position;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; i + j <= n; ++j) {
        const glm::dvec3 p = (a * double(i) + b * double(j) + c * double(n - i - j)) / double(n);
        worst = std::max(worst, std::abs(distance(p)));
      }
    }
  }
  return worst;
}

}  // namespace typodont::test
