// Labels of a jaw in a cone beam CT: bone, teeth, nerve canal, metal.
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "haptics/import/import.h"
#include "haptics/import/segment.h"

namespace typodont::haptics::importing {

/// Grey values of a jaw's materials. Dentin and cortical bone are about equally bright.
struct JawGreys {
  double soft = 0, cancellous = 0, hard = 0, enamel = 0;
  bool has_enamel = false;      // false: no crown is visible, and `enamel` is a guess
  std::optional<double> metal;  // grey value of metal; nullopt if the scan contains none

  // lower limit of the grey value of dentin and cortical bone
  double bright() const { return 0.5 * (cancellous + hard); }
  double crown() const { return 0.5 * (hard + enamel); }  // lower limit of the grey value of enamel
  // upper limit of the grey value of a canal in cancellous bone
  double canal() const { return 0.5 * (soft + cancellous); }
};

/// Finds the grey values by Otsu's method with two thresholds, from uniform regions brighter than `surface`. `offset`:
/// grey value of 0 Hounsfield units.
JawGreys find_jaw_greys(const Grid<float>& smoothed, double surface, double offset, double noise);

/// Standard deviation of the noise, from the differences of voxels that are three voxels apart. Valid if most of the
/// scan is uniform.
double noise_of(const Grid<float>& scan);

/// The walls of the scan or region that cut the tissue: the sample planes of the lower and upper wall of each axis;
/// nullopt: no tissue at this wall.
using CutWalls = std::array<std::array<std::optional<int>, 2>, 3>;

struct JawLabels {
  Sparse<Tissue> tissue;  // labels in the body and up to two samples around it
  JawReport report;       // centres of canals in samples of the grid
};

/// `scan`: the segmented grey values. `walls`: cuts; the surface there is not the jaw's own. `noise`: standard
/// deviation of their noise. `voxel`: m. `progress`: receives 0..1, may throw.
JawLabels label_jaw(const Grid<float>& scan, const Segmentation& s, const JawGreys& greys, const CutWalls& walls,
                    double noise, double voxel, const std::function<void(double)>& progress);

}  // namespace typodont::haptics::importing
