// Levels of detail of a tissue mesh: subdivided where it is too coarse, then simplified (meshoptimizer). Set-up time.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "haptics/contact/mesh_lod/triangle_grid.h"
#include "haptics/tissue_mesh.h"

namespace typodont::haptics::mesh_lod {

/// Vertices that triangles use.
std::size_t vertex_count(const TissueMesh& mesh);
/// Every triangle becomes four, by the midpoints of its edges: the surface stays where it is.
TissueMesh subdivided(const TissueMesh& mesh);
/// With about so many times as many triangles as it has, where borders allow it: one pass, for the geometry thread.
/// Borders as below.
TissueMesh thinned(const TissueMesh& mesh, double part);
/// With about so many vertices (within 1 % where the mesh's form allows it). Open borders stay as they are; borders
/// between tissues are only simplified along themselves. No vertex moves.
TissueMesh simplified(const TissueMesh& mesh, std::size_t vertices);

/// How finely a mesh is shown at which speed.
struct LevelOptions {
  std::optional<std::size_t> vertices;  // of the mesh that the levels are made of; none: as it comes
  std::vector<std::size_t> levels;      // vertices of each, finest first; empty: that mesh, and 0.4015 and 0.2246 of it
};

/// Finest first. Immutable; shared by carver and servo.
struct Levels {
  std::vector<TriangleGrid> grids;
  std::vector<std::size_t> vertices;  // of each
  TissueMesh finest;                  // the mesh of the first
};
/// Throws Error where the options ask for more vertices than can be made (levels in rising order, or none at all).
std::shared_ptr<const Levels> make_levels(const TissueMesh& mesh, const LevelOptions& options);
/// The mesh that the levels are made of.
TissueMesh base_mesh(TissueMesh mesh, const LevelOptions& options);

/// Greatest distance from the corners, edges' and faces' middles of one level to the other, both ways, m.
double hausdorff_distance(const TriangleGrid& one, const TriangleGrid& other);

}  // namespace typodont::haptics::mesh_lod
