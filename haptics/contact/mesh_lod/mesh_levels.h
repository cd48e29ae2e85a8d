// Makes a mesh's levels of detail: subdivides a mesh that is too coarse, simplifies with meshoptimizer. Set-up only.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "haptics/contact/mesh_lod/triangle_grid.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics::mesh_lod {

/// Number of vertices that belong to at least one triangle.
std::size_t vertex_count(const TissueMesh& mesh);
/// Divides each triangle into four. The surface does not change.
TissueMesh subdivided(const TissueMesh& mesh);
/// Simplifies the mesh in one pass to about the fraction `part` (0..1) of its triangles; more remain if borders must be
/// preserved. Carver thread.
TissueMesh thinned(const TissueMesh& mesh, double part);
/// Simplifies the mesh to `vertices` vertices, within 1 % if possible. The remaining vertices do not move; open borders
/// of the mesh and borders between tissues remain.
TissueMesh simplified(const TissueMesh& mesh, std::size_t vertices);

/// Numbers of vertices that the scene requests.
struct LevelOptions {
  // number of vertices of the mesh from which the levels are made; empty: the given mesh is used
  std::optional<std::size_t> vertices;
  // numbers of vertices of the levels of detail, finest first; empty: 100 %, 40.15 % and 22.46 % of the base mesh
  std::vector<std::size_t> levels;
};

/// The meshes of all levels of detail, finest first. Constant, and shared by the servo and the carver thread.
struct Levels {
  std::vector<TriangleGrid> grids;
  std::vector<std::size_t> vertices;  // number of vertices of each level, finest first
  TissueMesh finest;                  // mesh of the finest level
};
/// Throws Error if a level has more vertices than is possible or than the level before, or if there is no level.
std::shared_ptr<const Levels> make_levels(const TissueMesh& mesh, const LevelOptions& options);
/// Mesh from which the levels are made.
TissueMesh base_mesh(TissueMesh mesh, const LevelOptions& options);

}  // namespace typodont::haptics::mesh_lod
