// Finds the positions of the user's eyes. With the stylus tip, the user covers a dot that one eye sees, so eye, tip and
// dot lie on a line. Frame W, m; any thread.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibration/rig_geometry.h"

namespace typodont::calibration {

struct EyeAlignment {
  bool right = false;  // which eye saw the dot
  PanelPoint dot;
  dvec3 p_W{0, 0, 0};  // m, position of the stylus tip
};

/// The user touched a point that both eyes saw.
struct SeenTouch {
  dvec3 shown_W{0, 0, 0}, touched_W{0, 0, 0};
};

/// User's offset: position felt by the hand minus position seen.
struct UserOffset {
  // Offset and its standard deviation, m.
  dvec3 W{0, 0, 0}, sigma{0, 0, 0};
  int touches = 0, rejected = 0;
};

struct EyesResult {
  EyePair eyes;
  dvec3 center_sigma{0, 0, 0};  // m per axis, standard deviation of the eyes' centre
  double ipd_sigma = 0;         // m, standard deviation of the interpupillary distance
  // Noise of an alignment across the line of sight, and rms of the residuals, m.
  double sigma = 0, rms = 0;
  std::vector<std::size_t> rejected;      // indices of the rejected alignments of stylus tip and screen dot
  std::vector<double> residuals;          // m, residual of each alignment of stylus tip and screen dot
  std::string not_determined;             // what the alignments do not determine; empty: they determine all
  std::optional<UserOffset> user_offset;  // the user's offset, if it was requested
};

/// Finds the eyes. `rig`: panel, mirror, and approximate eyes.
EyesResult solve_eyes(std::span<const EyeAlignment> alignments, const RigGeometry& rig);

/// Mean of touched minus seen position, without outliers (detected by the median). Needs at least two touches. The
/// result includes the displacement of the arm's base, from which only joint_solver.h separates the user's offset.
UserOffset user_offset_of(std::span<const SeenTouch> touches);

}  // namespace typodont::calibration
