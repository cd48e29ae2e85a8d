// The panel and the mirror, from touches of the stylus. Frame W (the arm's points through X_WH); metres; any thread.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "calibration/rig_geometry.h"

namespace typodont::calibration {

/// A touch of a mark shown (or printed) at (u, v) of the panel's picture.
struct MarkTouch {
  PanelPoint mark;
  dvec3 p_W{0, 0, 0};
};

struct PanelResult {
  Panel panel;                   // a true rectangle
  double width = 0, height = 0;  // m
  double width_sigma = 0, height_sigma = 0;
  std::array<double, 3> centre_sigma{};  // m
  double tilt_sigma = 0;                 // rad, worst axis
  double sigma = 0, rms = 0;             // m
  std::vector<std::size_t> rejected;
  std::vector<double> residuals;  // m
  std::string not_determined;     // empty: all of it is
};

/// `tip_radius` m: of a ball at the stylus' end; it touches the side from which the picture is seen.
PanelResult solve_panel(std::span<const MarkTouch> touches, double tip_radius = 0);

struct MirrorResult {
  MirrorPlane mirror;
  double tilt_sigma = 0;    // rad, worst axis
  double offset_sigma = 0;  // m, at the middle of the touches
  double sigma = 0, rms = 0;
  std::vector<std::size_t> rejected;
  std::vector<double> residuals;  // m
  std::string not_determined;
};

/// The normal points to the side of `seen_from_W`, the eyes; touches are made on that side with a ball of `tip_radius`.
MirrorResult solve_mirror(std::span<const dvec3> touches_W, const dvec3& seen_from_W, double tip_radius = 0);

}  // namespace typodont::calibration
