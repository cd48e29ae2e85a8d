// Functions for tests of the surface: they sample bricks from formulas and check meshes.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "engine/contract/field_brick.h"
#include "engine/surface/mesh_export.h"
#include "engine/surface/surface_mesher.h"

namespace typodont::test {

using Field = std::function<double(const glm::dvec3&)>;  // distance in voxels at a point in voxels
using Labels = std::function<Tissue(const glm::dvec3&)>;

/// Returns the samples of one brick. Distances are limited to ±band, as in a narrow band.
FieldBrick sample_brick(const glm::ivec3& key, const Field& field, const Labels& labels = {}, double band = 4);
/// Returns all bricks within [low, high] (voxels) whose cell corners have both signs.
std::vector<FieldBrick> sample_bricks(const glm::dvec3& low, const glm::dvec3& high, const Field& field,
                                      const Labels& labels = {}, double band = 4);
bool has_surface(const FieldBrick& brick);
/// Hash of all vertices and triangles that the mesher keeps.
std::uint64_t mesh_hash(const surface::SurfaceMesher& mesher);
/// Number of triangles that the mesher keeps.
inline std::size_t triangle_count(const surface::SurfaceMesher& mesher) {
  std::size_t count = 0;
  for (const glm::ivec3& key : mesher.keys()) count += mesher.find(key)->indices.size() / 3;
  return count;
}

surface::SurfaceMesher mesh_of(const std::vector<FieldBrick>& bricks, float tolerance);

struct Topology {
  bool closed = false;    // every edge has exactly two triangles
  bool oriented = false;  // the two triangles of an edge traverse it in opposite directions
  bool manifold = false;  // the triangles around every vertex form one fan
  long euler = 0;         // V − E + F
  int components = 0;
  double volume = 0;      // voxels³, positive if the triangles face outward
  std::string complaint;  // description of the first error
};
Topology topology_of(const surface::WholeMesh& mesh);

/// Returns the largest |distance| at a fine grid of points on every triangle: corners, edges and inside, n per side.
double max_error(const surface::WholeMesh& mesh, const Field& distance, int n = 6);

}  // namespace typodont::test
