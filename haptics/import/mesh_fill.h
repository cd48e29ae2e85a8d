// Fills triangle meshes to solids on a grid.
#pragma once

#include <span>
#include <vector>

#include "haptics/import/distance.h"

namespace typodont::haptics::importing {

struct FilledMesh {
  Grid<float> distance;  // voxels, negative inside; clamped to the band outside
  Mask part;             // number of the part for every sample inside, from 1; 0 outside
  bool capped = false;   // true: an opening was closed by a cap, at the winding number 0.5
  bool sheet = false;    // true: the mesh encloses no volume, so it becomes a shell of two voxels
};

/// Fills the parts of a mesh. A sample is inside a part if its generalized winding number (winding_sixths) is 0.5 or
/// more. The body is the union of all parts; where parts overlap, the later part is used. Cracks between parts, up to
/// three voxels wide, are filled with one of the parts. Triangles within the body do not count for the distance.
/// Triangles are in the index space of the grid; `band` in voxels.
FilledMesh fill_mesh(std::span<const std::vector<Triangle>> parts, const glm::ivec3& size, double band);

/// Assigns the nearest part to samples up to `reach` voxels outside the body, so that labels can be read at the
/// surface.
void spread_parts(FilledMesh& filled, double reach);

}  // namespace typodont::haptics::importing
