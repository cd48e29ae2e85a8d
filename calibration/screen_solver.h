// Calibrates the panel and the mirror from touches with the stylus. Points are in frame W: the arm measures them in
// frame H, and the caller transforms them by X_WH. Metres; any thread may call it.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "calibration/rig_geometry.h"

namespace typodont::calibration {

/// A touch of a mark that is shown (or printed) at (u, v) of the panel's picture.
struct MarkTouch {
  PanelPoint mark;
  dvec3 p_W{0, 0, 0};
};

struct PanelResult {
  Panel panel;                   // the panel that fits best, as an exact rectangle
  double width = 0, height = 0;  // m, width and height of the panel's picture
  double width_sigma = 0, height_sigma = 0;
  std::array<double, 3> centre_sigma{};  // m, standard deviation of the panel's centre
  /// rad, standard deviation of the panel's tilt about the axis for which this standard deviation is largest
  double tilt_sigma = 0;
  // m; sigma: standard deviation of the noise of a touch; rms: root mean square residual of the touches that are not
  // rejected
  double sigma = 0, rms = 0;
  std::vector<std::size_t> rejected;  // indices of the rejected touches
  std::vector<double> residuals;      // m, residual of each touch
  std::string not_determined;         // parameters that the touches do not determine; empty: none
};

/// Estimates the panel. `tip_radius`: m, radius of a ball at the end of the stylus. The ball touches the visible side
/// of the panel.
PanelResult solve_panel(std::span<const MarkTouch> touches, double tip_radius = 0);

struct MirrorResult {
  MirrorPlane mirror;
  // rad, standard deviation of the mirror's tilt about the axis for which this standard deviation is largest
  double tilt_sigma = 0;
  double offset_sigma = 0;  // m, standard deviation of the plane's offset, at the centre of the touches
  double sigma = 0, rms = 0;
  std::vector<std::size_t> rejected;  // indices of the rejected touches
  std::vector<double> residuals;      // m, residual of each touch
  std::string not_determined;
};

/// Estimates the mirror. The normal points towards `seen_from_W`, the position of the eyes. A ball with radius
/// `tip_radius` touches the side that faces the eyes.
MirrorResult solve_mirror(std::span<const dvec3> touches_W, const dvec3& seen_from_W, double tip_radius = 0);

}  // namespace typodont::calibration
