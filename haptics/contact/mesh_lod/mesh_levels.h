// Creates the levels of detail of a tissue mesh: subdivides a mesh that is too coarse, then simplifies (meshoptimizer).
// Set-up time.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "haptics/contact/mesh_lod/triangle_grid.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics::mesh_lod {

/// Number of vertices that are used by triangles.
std::size_t vertex_count(const TissueMesh& mesh);
/// Divides every triangle into four at the midpoints of its edges; the surface does not change.
TissueMesh subdivided(const TissueMesh& mesh);
/// Simplifies in one pass to about `part` times the number of triangles, as far as borders allow it. For the geometry
/// thread. Borders are treated as in simplified().
TissueMesh thinned(const TissueMesh& mesh, double part);
/// Simplifies to about this many vertices (within 1 % if the mesh allows it). Open borders do not change; a border
/// between tissues is simplified only along its own line. No vertex moves.
TissueMesh simplified(const TissueMesh& mesh, std::size_t vertices);

/// The resolution of each level.
struct LevelOptions {
  // number of vertices of the mesh from which the levels are made; none: the given mesh is used
  std::optional<std::size_t> vertices;
  // number of vertices of each level, finest first; empty: all vertices of the mesh, and 0.4015 and 0.2246 of them
  std::vector<std::size_t> levels;
};

/// The levels, finest first. Immutable; carver and servo use the same object.
struct Levels {
  std::vector<TriangleGrid> grids;
  std::vector<std::size_t> vertices;  // number of vertices of each level
  TissueMesh finest;                  // mesh of the first level
};
/// Throws Error if the options request more vertices than possible, levels in increasing order, or no level.
std::shared_ptr<const Levels> make_levels(const TissueMesh& mesh, const LevelOptions& options);
/// The mesh from which the levels are made.
TissueMesh base_mesh(TissueMesh mesh, const LevelOptions& options);

/// Hausdorff distance in m between two levels, evaluated at corners and at the midpoints of edges and faces, in both
/// directions.
double hausdorff_distance(const TriangleGrid& one, const TriangleGrid& other);

}  // namespace typodont::haptics::mesh_lod
