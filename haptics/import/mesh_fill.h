// Converts triangle meshes to solids on a grid.
#pragma once

#include <span>
#include <vector>

#include "haptics/import/distance.h"

namespace typodont::haptics::importing {

struct FilledMesh {
  Sparse<float> distance;  // voxels, negative inside; stored only in a band around the surface
  Mask part;               // number of the part that contains the voxel, from 1; 0 outside
  bool capped = false;     // true: the mesh had openings, which were closed where the winding number is 0.5
  bool sheet = false;      // true: the mesh encloses no volume, and was thickened to two voxels
};

/// Fills the union of the parts: voxels with winding number ≥ 0.5. Where parts overlap, the last one counts. Cracks up
/// to three voxels are filled. Triangles in voxel coordinates; `band` in voxels.
FilledMesh fill_mesh(std::span<const std::vector<Triangle>> parts, const glm::ivec3& size, double band);

/// Copies part numbers to voxels up to `reach` voxels outside the parts, so that labels can be read at the surface.
void spread_parts(FilledMesh& filled, double reach);

/// Memory of fill_mesh() and of the FilledMesh, bytes.
double memory_of_filling(std::span<const std::vector<Triangle>> parts, const glm::ivec3& size, double band);

}  // namespace typodont::haptics::importing
