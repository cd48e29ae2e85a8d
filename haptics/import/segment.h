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

/// Result on a cubic grid about as fine as the scan, with a margin. Only samples in and near tissue are stored.
struct Segmentation {
  // Fraction of tissue minus its value at the surface: positive in the body, including its cavities. Empty if distances
  // were requested.
  Sparse<float> phi;
  // A field that is positive in the denser tissue, and at samples just outside the surface beside it.
  Sparse<float> dense;
  Sparse<float> cavity;  // a field that is positive in pulp or marrow spaces
  // Grey values without the dim edge of the body.
  Sparse<float> grey;
  DistanceField surface;  // distances to phi = 0, at least within the band
  double blur = 0;        // voxels, standard deviation of the scan's blur, measured at edges
  // Corrected standard deviation of the blur, voxels. In a jaw, `blur` is too large, because it is not measured exactly
  // at the middle of an edge.
  double true_blur = 0;
  int bodies_kept = 0;
  int cavity_parts = 0;
};

/// Standard deviation of a border's position, voxels. `noise`: of grey values, divided by the contrast; `blur`: voxels.
double border_uncertainty(double noise, double blur);

/// The samples at the walls (outer faces) of `grey` must be surroundings. `voxel`: m. `band`: distance up to which
/// distances are exact, voxels; empty: computes no distances.
Segmentation segment(const Grid<float>& grey, const Levels& levels, double voxel, ImportPreset preset,
                     const std::optional<double>& band, const std::function<void(double)>& progress);

}  // namespace typodont::haptics::importing
