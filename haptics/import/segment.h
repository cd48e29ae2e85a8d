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

/// The result of the segmentation on the working grid. This grid has cubic voxels, is about as fine as the scan, and
/// has a margin of surroundings on all sides. Values are stored only in the blocks of the body and in the blocks next
/// to them.
struct Segmentation {
  // Occupancy (0: surroundings, 1: tissue) minus its value at the surface: positive in the body (including cavities), 0
  // on the outer surface. Empty if distances were requested.
  Sparse<float> phi;
  // a field that is positive in the denser tissue; also valid up to some voxels outside the surface
  Sparse<float> dense;
  Sparse<float> cavity;  // a field that is positive in pulp or marrow spaces
  // Grey values without the dim outer edge. At the edge and outside, they are replaced by the brightest value further
  // inward.
  Sparse<float> grey;
  DistanceField surface;  // distances to the surface phi = 0, at least up to the requested band
  double blur = 0;        // voxels, standard deviation of the scan's blur, measured at edges
  // voxels, corrected value of `blur`: in a jaw, `blur` is too large, because it is measured beside the centres of the
  // edges
  double true_blur = 0;
  int bodies_kept = 0;
  int cavity_parts = 0;
};

/// Returns the standard deviation, in voxels, of the position of a border between two tissues. `noise` is the standard
/// deviation of the noise divided by the difference between the grey values of the tissues. `blur`: voxels.
double border_uncertainty(double noise, double blur);

/// Segments the grey values `grey`. The walls of the box must belong to the surroundings. `voxel` is in m. `band` is
/// the distance from the surface, in voxels, up to which exact distances are needed; without a value, none are needed.
Segmentation segment(const Grid<float>& grey, const Levels& levels, double voxel, ImportPreset preset,
                     const std::optional<double>& band, const std::function<void(double)>& progress);

}  // namespace typodont::haptics::importing
