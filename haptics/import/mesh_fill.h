// Converts triangle meshes to solids on a grid.
#pragma once

#include <span>
#include <vector>

#include "haptics/import/distance.h"

namespace typodont::haptics::importing {

struct FilledMesh {
  Sparse<float> distance;  // signed distance in voxels, negative inside, limited to ± the band; stored near the surface
  Mask part;               // for every sample: number of the part (from 1) that contains it; 0 outside
  bool capped = false;     // true if the mesh had an opening, which was closed by a cap where the winding number is 0.5
  bool sheet = false;  // true if the mesh encloses no volume; it then becomes a shell with a thickness of two voxels
};

/// Fills the parts of a mesh. A sample is inside a part if its generalized winding number is at least 0.5 (that is, at
/// least 3 if the number is multiplied by six as in WindingNumbers). The body is the union of all parts. A sample in
/// several parts belongs to the last of these parts. Cracks of up to three voxels between parts are filled. Triangles
/// within the body do not count for the distance. The triangles are in the index space of the grid, and `band` is in
/// voxels.
FilledMesh fill_mesh(std::span<const std::vector<Triangle>> parts, const glm::ivec3& size, double band);

/// Extends the parts by `reach` voxels outside the body: each sample there gets the nearest part. So labels can be read
/// at the surface.
void spread_parts(FilledMesh& filled, double reach);

/// Estimates the memory in bytes that fill_mesh() and its result need.
double memory_of_filling(std::span<const std::vector<Triangle>> parts, const glm::ivec3& size, double band);

}  // namespace typodont::haptics::importing
