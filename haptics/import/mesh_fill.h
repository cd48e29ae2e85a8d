// Converts triangle meshes to solids on a grid.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "haptics/dense_tissue.h"
#include "haptics/import/distance.h"
#include "haptics/import/import_scan.h"

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

/// Returns an empty volume that encloses a mesh between `lo` and `hi`. All lengths in m.
DenseTissue volume_around(const glm::dvec3& lo, const glm::dvec3& hi, double voxel, double band);

/// Copies distances and labels to the volume. `label(p, d)`: tissue at sample p with distance d (m).
template <class Label>
void store(const FilledMesh& filled, DenseTissue& out, Label label) {
  const double voxel = out.frame.voxel;
  out.distance.resize(filled.part.v.size());
  out.tissue.assign(out.distance.size(), Tissue::kAir);
  for_each_voxel_in_parallel(out.size, [&](int x, int y, int z) {
    const glm::ivec3 p(x, y, z);
    const std::size_t i = out.at(x, y, z);
    const double d = static_cast<double>(filled.distance[p]) * voxel;
    out.distance[i] = static_cast<float>(std::clamp(d, -out.band, out.band));
    if (d <= kLabelReach * voxel) out.tissue[i] = label(p, d);
  });
}

/// Memory of fill_mesh() and of the FilledMesh, bytes.
double memory_of_filling(std::span<const std::vector<Triangle>> parts, const glm::ivec3& size, double band);

}  // namespace typodont::haptics::importing
