// Converts triangle meshes to solids on a grid.
#pragma once

#include <span>
#include <vector>

#include "haptics/import/distance.h"

namespace typodont::haptics::importing {

struct FilledMesh {
  Sparse<float> distance;  // voxels, negative inside, within the band
  Mask part;               // from 1; 0 outside
  bool capped = false;     // openings closed at winding number 0.5
  bool sheet = false;      // no volume: a shell of two voxels
};

/// Union of parts with winding number ≥ 0.5 (3 sixths); the last part wins; cracks up to three voxels are filled;
/// buried triangles do not count. Index space, `band` in voxels.
FilledMesh fill_mesh(std::span<const std::vector<Triangle>> parts, const glm::ivec3& size, double band);

/// Nearest part, `reach` voxels outwards, for labels at the surface.
void spread_parts(FilledMesh& filled, double reach);

/// bytes of fill_mesh() and its result.
double memory_of_filling(std::span<const std::vector<Triangle>> parts, const glm::ivec3& size, double band);

}  // namespace typodont::haptics::importing
