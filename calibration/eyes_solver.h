// Estimates the positions of a user's eyes. A dot is shown to one eye at a time, and the user holds the stylus tip so
// that it covers the dot. Eye, tip and dot then lie on one line. Frame W, metres; any thread may call it.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibration/rig_geometry.h"

namespace typodont::calibration {

struct EyeAlignment {
  bool right = false;  // true: the right eye saw the dot; false: the left eye
  PanelPoint dot;
  dvec3 p_W{0, 0, 0};  // m, position of the stylus tip
};

/// A touch of a point seen with both eyes. Used to measure the user's offset between seeing and feeling.
struct SeenTouch {
  dvec3 shown_W{0, 0, 0}, touched_W{0, 0, 0};
};

/// Systematic offset between the positions that a user feels and sees.
struct UserOffset {
  // m, position that the user touched minus position that the user saw; sigma: standard deviation of this difference
  dvec3 W{0, 0, 0}, sigma{0, 0, 0};
  int touches = 0, rejected = 0;
};

struct EyesResult {
  EyePair eyes;
  std::array<double, 3> center_sigma{};  // m per axis, standard deviation of the eyes' centre
  double ipd_sigma = 0;                  // m, standard deviation of the interpupillary distance
  // m; an alignment is a touch at which the tip covers a dot, and its residual is the distance of the tip from the line
  // of sight. sigma: standard deviation of the noise in each direction perpendicular to this line; rms: root mean
  // square of the residuals.
  double sigma = 0, rms = 0;
  std::vector<std::size_t> rejected;      // indices of the rejected alignments of tip and dot
  std::vector<double> residuals;          // m, residual of each alignment of tip and dot
  std::string not_determined;             // parameters that the alignments do not determine; empty: all are known
  std::optional<UserOffset> user_offset;  // the user's offset, if it was requested
};

/// Estimates the eyes. `rig` contains the panel and the mirror; its eyes are the initial guess.
EyesResult solve_eyes(std::span<const EyeAlignment> alignments, const RigGeometry& rig);

/// Returns the mean of the touched minus the seen positions, without outliers. Outliers are found by their distance
/// from the median. Needs at least two touches. A displaced haptic base has the same effect as a user's offset, so the
/// base must be calibrated separately (joint_solver.h distinguishes both).
UserOffset user_offset_of(std::span<const SeenTouch> touches);

}  // namespace typodont::calibration
