// Finds the labels of a jaw in a cone beam CT: bone, teeth, nerve canal, metal.
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "haptics/import/import.h"
#include "haptics/import/segment.h"

namespace typodont::haptics::importing {

/// Grey values of the materials in a jaw. Dentin and cortical bone are about equally bright, so they have one value.
struct JawGreys {
  double soft = 0, cancellous = 0, hard = 0, enamel = 0;
  bool has_enamel = false;      // false if no crown is visible, so that `enamel` is a guess
  std::optional<double> metal;  // grey value of metal; no value if the scan contains no metal

  // Returns the lowest grey value of dentin and cortical bone.
  double bright() const { return 0.5 * (cancellous + hard); }
  double crown() const { return 0.5 * (hard + enamel); }  // returns the lowest grey value of enamel
  // Returns the highest grey value of a canal in cancellous bone.
  double canal() const { return 0.5 * (soft + cancellous); }
};

/// Finds the grey values with two thresholds (Otsu's method) in uniform regions brighter than `surface`. `offset` is
/// the grey value of 0 Hounsfield units, and `noise` the standard deviation of the noise.
JawGreys find_jaw_greys(const Grid<float>& smoothed, double surface, double offset, double noise);

/// Returns the standard deviation of the scan's noise, computed from the differences of voxels that are three voxels
/// apart. Valid if most of the scan is uniform.
double noise_of(const Grid<float>& scan);

/// Walls of the scan or region that cut through the tissue. For the lower and the upper wall on each axis: the index of
/// the plane of samples at this wall, or no value if there is no tissue at it.
using CutWalls = std::array<std::array<std::optional<int>, 2>, 3>;

struct JawLabels {
  Sparse<Tissue> tissue;  // labels of the samples inside the body and up to two samples outside it
  JawReport report;       // facts about the labels; the centres of canals and teeth are in samples of the grid
};

/// Finds the labels of a jaw. `scan` contains the grey values that were segmented, and `noise` is the standard
/// deviation of their noise. `walls` are the walls that cut through the jaw; the surface there is not the true surface
/// of the jaw. `voxel` is in m. `progress` is called with 0..1 and may throw.
JawLabels label_jaw(const Grid<float>& scan, const Segmentation& s, const JawGreys& greys, const CutWalls& walls,
                    double noise, double voxel, const std::function<void(double)>& progress);

}  // namespace typodont::haptics::importing
