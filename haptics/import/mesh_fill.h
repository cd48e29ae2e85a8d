// Triangle meshes filled to solids on a grid.
#pragma once

#include <span>
#include <vector>

#include "haptics/import/distance.h"

namespace typodont::haptics::importing {

struct FilledMesh {
  Grid<float> distance;  // voxels, negative inside, clamped to the band outside it
  Mask part;             // of every sample inside: the number of its part, from 1; 0 outside
  bool capped = false;   // openings were closed where the winding number is a half
  bool sheet = false;    // encloses nothing: a shell two voxels thick
};

/// Inside a part is where its generalized winding number (winding_sixths) is a half or more; the body is all parts
/// together. Where parts overlap the later one counts. Cracks between parts up to three voxels wide belong to one of
/// them. Triangles within the body bound nothing: they are left out of the distance. In the grid's own index space;
/// `band` in voxels.
FilledMesh fill_mesh(std::span<const std::vector<Triangle>> parts, const glm::ivec3& size, double band);

/// Up to `reach` voxels outside the body its nearest part, so that labels can be read at the surface.
void spread_parts(FilledMesh& filled, double reach);

}  // namespace typodont::haptics::importing
