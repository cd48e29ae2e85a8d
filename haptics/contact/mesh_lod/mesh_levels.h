// Subdivides a mesh that is too coarse, simplifies by meshoptimizer. Set-up.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "haptics/contact/mesh_lod/triangle_grid.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics::mesh_lod {

/// With at least one triangle.
std::size_t vertex_count(const TissueMesh& mesh);
/// Four per triangle, same surface.
TissueMesh subdivided(const TissueMesh& mesh);
/// One pass to about `part` of the triangles, or more if borders forbid. Carver thread.
TissueMesh thinned(const TissueMesh& mesh, double part);
/// Within 1 % if possible. Open borders stay, borders of tissues keep their line; vertices do not move.
TissueMesh simplified(const TissueMesh& mesh, std::size_t vertices);

/// Requested vertices.
struct LevelOptions {
  // of the base mesh; empty: the given mesh
  std::optional<std::size_t> vertices;
  // finest first; empty: 100 %, 40.15 % and 22.46 %
  std::vector<std::size_t> levels;
};

/// Finest first; constant, shared by both threads.
struct Levels {
  std::vector<TriangleGrid> grids;
  std::vector<std::size_t> vertices;  // number of vertices of each level, finest first
  TissueMesh finest;                  // mesh of the finest level
};
/// Throws Error for more vertices than possible, increasing levels, or an empty list.
std::shared_ptr<const Levels> make_levels(const TissueMesh& mesh, const LevelOptions& options);
/// From which levels are made.
TissueMesh base_mesh(TissueMesh mesh, const LevelOptions& options);
/// Without opposite pairs on the same corners, which a flat surface's simplification leaves: an edge with four faces
/// would count as border.
TissueMesh without_double_faces(const TissueMesh& mesh);

/// m, larger one-sided Hausdorff distance, at corners and midpoints.
double hausdorff_distance(const TriangleGrid& one, const TriangleGrid& other);

}  // namespace typodont::haptics::mesh_lod
