// Finds arm, panel, mirror, eyes and user offset together, so that they explain all touches, and no step passes its
// errors to the next one. Touches seen with both eyes locate an eye better than alignments do. Metres; any thread.
#pragma once

#include <string>
#include <vector>

#include "calibration/routine.h"

namespace typodont::calibration {

struct JointResult {
  ArmGeometry arm;
  Panel panel;
  std::optional<MirrorPlane> mirror;
  EyePair eyes;
  /// m, position felt minus position seen, and its standard deviation
  dvec3 user_offset_W{0, 0, 0}, user_offset_sigma{0, 0, 0};
  dvec3 eye_center_sigma{0, 0, 0};  // m, standard deviation of the eyes' centre
  double ipd_sigma = 0;             // m, standard deviation of the interpupillary distance
  struct Kind {
    std::string name;
    int touches = 0, rejected = 0;
    // Rms of all residual components before and after the solution, m.
    double before_rms = 0, after_rms = 0;
  };
  std::vector<Kind> kinds;
  double seconds = 0;
};

/// Throws Error without touches of marks, captures of both eyes, or recorded dots. X_WH does not change, because it
/// defines W.
JointResult solve_jointly(const BenchState& bench, const Captures& captures);

}  // namespace typodont::calibration
