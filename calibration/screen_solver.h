// Finds panel and mirror from touches. The caller transforms positions from H to W. Metres; any thread.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "calibration/rig_geometry.h"

namespace typodont::calibration {

/// Touch of a mark at (u, v) on the panel.
struct MarkTouch {
  PanelPoint mark;
  dvec3 p_W{0, 0, 0};
};

struct PanelResult {
  Panel panel;                   // the panel that fits best, as an exact rectangle
  double width = 0, height = 0;  // m, width and height of the panel's picture
  double width_sigma = 0, height_sigma = 0;
  dvec3 centre_sigma{0, 0, 0};  // m per axis, standard deviation of the panel's centre
  /// Standard deviation of the panel's rotation about its least certain axis, rad.
  double tilt_sigma = 0;
  // Noise of a touch per axis, and rms of the residuals without rejected touches, m.
  double sigma = 0, rms = 0;
  std::vector<std::size_t> rejected;  // indices of the rejected touches
  std::vector<double> residuals;      // m, residual of each touch
  std::string not_determined;         // parameters that the touches do not determine; empty: none
};

/// `tip_radius`: radius of a ball at the tip that touches the visible side, m.
PanelResult solve_panel(std::span<const MarkTouch> touches, double tip_radius = 0);

struct MirrorResult {
  MirrorPlane mirror;
  // Standard deviation of the mirror's rotation about its least certain axis, rad.
  double tilt_sigma = 0;
  double offset_sigma = 0;  // m, standard deviation of the mirror's position along its normal
  double sigma = 0, rms = 0;
  std::vector<std::size_t> rejected;  // indices of the rejected touches
  std::vector<double> residuals;      // m, residual of each touch
  std::string not_determined;
};

/// The normal points towards `seen_from_W`; a ball of `tip_radius` (m) touches that side.
MirrorResult solve_mirror(std::span<const dvec3> touches_W, const dvec3& seen_from_W, double tip_radius = 0);

}  // namespace typodont::calibration
