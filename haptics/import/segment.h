// Segmentation: computes a surface and labels from grey values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "haptics/import/blocks.h"
#include "haptics/import/distance.h"
#include "haptics/import/grid.h"
#include "haptics/import/levels.h"

namespace typodont::haptics::importing {

/// Cubic working grid about as fine as the scan, with a margin; stored at the body and beside it.
struct Segmentation {
  // Occupancy minus its surface value: positive in the body with cavities. Empty if distances were requested.
  Sparse<float> phi;
  // positive in the denser tissue, also some voxels outside
  Sparse<float> dense;
  Sparse<float> cavity;  // a field that is positive in pulp or marrow spaces
  // without the dim edge
  Sparse<float> grey;
  DistanceField surface;  // to phi = 0, at least the band
  double blur = 0;        // voxels, standard deviation of the scan's blur, measured at edges
  // voxels; `blur` is too large in a jaw, measured beside the edges' centres
  double true_blur = 0;
  int bodies_kept = 0;
  int cavity_parts = 0;
};

/// σ of a border's position, voxels. `noise`: σ / contrast; `blur`: voxels.
double border_uncertainty(double noise, double blur);

/// Walls are surroundings. `voxel`: m; `band`: voxels of exact distances; empty: none.
Segmentation segment(const Grid<float>& grey, const Levels& levels, double voxel, ImportPreset preset,
                     const std::optional<double>& band, const std::function<void(double)>& progress);

}  // namespace typodont::haptics::importing
