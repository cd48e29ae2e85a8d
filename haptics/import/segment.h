// From greys to a surface and labels.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "haptics/import/blocks.h"
#include "haptics/import/distance.h"
#include "haptics/import/grid.h"
#include "haptics/import/levels.h"

namespace typodont::haptics::importing {

/// All on the working grid: isotropic, about as fine as the scan, the body with a margin of surround on all sides. Kept
/// in the blocks of the body and those next to it.
struct Segmentation {
  Sparse<float> phi;     // occupancy − the surface's height: positive in the body (cavities included), 0 on its outer
                         // surface; empty where distances were asked for
  Sparse<float> dense;   // positive where the denser tissue is; told also some voxels outside the surface
  Sparse<float> cavity;  // positive in pulp or marrow spaces
  Sparse<float> grey;    // the scan's, without the dim outer edge: there, and outside, the brightest on the way inwards
  DistanceField surface;  // of phi, at least as far as was asked for
  double blur = 0;        // voxels, standard deviation of the scan's edge response
  int bodies_kept = 0;
  int cavity_parts = 0;
};

/// `grey` must be surround on its walls. `voxel` in m. `band`: voxels, as far as distances to the
/// surface are wanted; none: not on this grid.
Segmentation segment(const Grid<float>& grey, const Levels& levels, double voxel, ImportPreset preset,
                     const std::optional<double>& band, const std::function<void(double)>& progress);

}  // namespace typodont::haptics::importing
