// Creates the levels of detail of a tissue mesh. A mesh that is too coarse is first subdivided. The library
// meshoptimizer then simplifies it. Used at set-up.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "haptics/contact/mesh_lod/triangle_grid.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics::mesh_lod {

/// Returns the number of vertices that belong to at least one triangle.
std::size_t vertex_count(const TissueMesh& mesh);
/// Returns the mesh with every triangle divided into four at the midpoints of its edges; the surface does not change.
TissueMesh subdivided(const TissueMesh& mesh);
/// Simplifies a mesh in one pass to about `part` times its number of triangles. The result has more triangles if the
/// borders, which simplified() preserves, allow no further simplification. Carver thread only.
TissueMesh thinned(const TissueMesh& mesh, double part);
/// Simplifies a mesh to about the given number of vertices (within 1 % if the mesh allows it). Open borders do not
/// change. A border between two tissues keeps its line but may lose vertices. Remaining vertices do not move.
TissueMesh simplified(const TissueMesh& mesh, std::size_t vertices);

/// Requested numbers of vertices of the levels of detail.
struct LevelOptions {
  // number of vertices of the base mesh, from which the levels are made; empty: the given mesh is the base mesh
  std::optional<std::size_t> vertices;
  // number of vertices of each level, finest first; empty: three levels with 100 %, 40.15 % and 22.46 % of the vertices
  // of the base mesh
  std::vector<std::size_t> levels;
};

/// The levels of detail, finest first. They never change, and the carver and servo threads use the same object.
struct Levels {
  std::vector<TriangleGrid> grids;
  std::vector<std::size_t> vertices;  // number of vertices of each level, finest first
  TissueMesh finest;                  // mesh of the finest level
};
/// Creates the levels. Throws Error in three cases: the options request more vertices than the mesh can have, they list
/// the levels in increasing order, or their list of levels is empty.
std::shared_ptr<const Levels> make_levels(const TissueMesh& mesh, const LevelOptions& options);
/// Returns the base mesh, from which the levels are made.
TissueMesh base_mesh(TissueMesh mesh, const LevelOptions& options);
/// Returns the mesh without pairs of faces that have the same corners and opposite orientations. The simplification of
/// a flat surface makes such pairs; an edge beside them has four faces, which an editable mesh treats as a border.
TissueMesh without_double_faces(const TissueMesh& mesh);

/// Returns the larger of the two one-sided Hausdorff distances between two levels, m. It is evaluated at corners and at
/// the midpoints of edges and faces.
double hausdorff_distance(const TriangleGrid& one, const TriangleGrid& other);

}  // namespace typodont::haptics::mesh_lod
