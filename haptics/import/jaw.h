// Labels the tissues of a jaw in cone beam CT.
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "haptics/import/import.h"
#include "haptics/import/segment.h"

namespace typodont::haptics::importing {

/// Grey values of a jaw's tissues. Dentin and cortical bone share the value `hard`.
struct JawGreys {
  double soft = 0, cancellous = 0, hard = 0, enamel = 0;
  bool has_enamel = false;      // false: no crown was found, and `enamel` is a guess
  std::optional<double> metal;  // empty: no metal

  // Returns the lowest grey value of dentin and cortical bone.
  double bright() const { return 0.5 * (cancellous + hard); }
  double crown() const { return 0.5 * (hard + enamel); }  // returns the lowest grey value of enamel
  // Returns the highest grey value of a canal.
  double canal() const { return 0.5 * (soft + cancellous); }
};

/// Finds the grey values with Otsu's method, in uniform regions brighter than the grey value `surface`. `offset`: grey
/// value of 0 Hounsfield units; `noise`: standard deviation.
JawGreys find_jaw_greys(const Grid<float>& smoothed, double surface, double offset, double noise);

/// Standard deviation of the noise, from differences of voxels three apart. Valid if most of the scan is uniform.
double noise_of(const Grid<float>& scan);

/// For each axis, the planes at the lower and upper wall (outer face) of the scan, if tissue touches them.
using CutWalls = std::array<std::array<std::optional<int>, 2>, 3>;

struct JawLabels {
  Sparse<Tissue> tissue;  // labels, also up to two samples outside the surface
  JawReport report;       // report for the user; positions in samples
};

/// `scan`: the segmented scan; `noise`: standard deviation of its noise; `walls`: walls that cut the jaw; `voxel`: m.
/// `progress` receives 0..1, and may throw.
JawLabels label_jaw(const Grid<float>& scan, const Segmentation& s, const JawGreys& greys, const CutWalls& walls,
                    double noise, double voxel, const std::function<void(double)>& progress);

}  // namespace typodont::haptics::importing
