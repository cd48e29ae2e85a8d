// Labels of a jaw in a cone beam CT.
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "haptics/import/import.h"
#include "haptics/import/segment.h"

namespace typodont::haptics::importing {

/// Dentin and cortical bone share one value.
struct JawGreys {
  double soft = 0, cancellous = 0, hard = 0, enamel = 0;
  bool has_enamel = false;      // false: no crown, `enamel` is a guess
  std::optional<double> metal;  // empty: no metal

  // Returns the lowest grey value of dentin and cortical bone.
  double bright() const { return 0.5 * (cancellous + hard); }
  double crown() const { return 0.5 * (hard + enamel); }  // returns the lowest grey value of enamel
  // Highest of a canal.
  double canal() const { return 0.5 * (soft + cancellous); }
};

/// Otsu in uniform regions above `surface`. `offset`: of 0 Hounsfield units; `noise`: σ.
JawGreys find_jaw_greys(const Grid<float>& smoothed, double surface, double offset, double noise);

/// From differences three voxels apart, if most of the scan is uniform.
double noise_of(const Grid<float>& scan);

/// Plane at the lower and upper wall of each axis that cuts tissue.
using CutWalls = std::array<std::array<std::optional<int>, 2>, 3>;

struct JawLabels {
  Sparse<Tissue> tissue;  // up to two samples outside
  JawReport report;       // centres in samples
};

/// `scan` as segmented, `noise` its σ; `walls` cut the jaw; `voxel` in m; `progress` 0..1 may throw.
JawLabels label_jaw(const Grid<float>& scan, const Segmentation& s, const JawGreys& greys, const CutWalls& walls,
                    double noise, double voxel, const std::function<void(double)>& progress);

}  // namespace typodont::haptics::importing
