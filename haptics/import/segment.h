// Segmentation: from grey values to a surface and labels.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "haptics/import/blocks.h"
#include "haptics/import/distance.h"
#include "haptics/import/grid.h"
#include "haptics/import/levels.h"

namespace typodont::haptics::importing {

/// Fields on the working grid: isotropic, about as fine as the scan, with a margin of surroundings on all sides. Stored
/// in the blocks of the body and their neighbours.
struct Segmentation {
  // Occupancy minus the surface's height: positive in the body (cavities included), 0 on its outer surface. Empty if
  // distances were requested
  Sparse<float> phi;
  Sparse<float> dense;   // positive in the denser tissue; also valid some voxels outside the surface
  Sparse<float> cavity;  // positive in pulp or marrow spaces
  // grey values without the dim outer edge: at the edge and outside, the brightest value further inward
  Sparse<float> grey;
  DistanceField surface;  // distance to the surface phi = 0, at least up to the requested band
  double blur = 0;        // voxels, standard deviation of the scan's edge response
  int bodies_kept = 0;
  int cavity_parts = 0;
};

/// `grey`: the grey values; the walls of the box must belong to the surroundings. `voxel`: m. `band`: voxels,
/// distance from the surface up to which distances are needed; nullopt: no distances are needed on this grid.
Segmentation segment(const Grid<float>& grey, const Levels& levels, double voxel, ImportPreset preset,
                     const std::optional<double>& band, const std::function<void(double)>& progress);

}  // namespace typodont::haptics::importing
