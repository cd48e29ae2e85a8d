// Solves all captures together: one set of values for arm, panel, mirror, eyes and the user's offset must explain all
// touches. The results of the separate steps are the initial guess. An error in one step's result also causes errors in
// the results of later steps; the joint solution removes them. For example, eye touches alone determine an eye only to
// millimetres; touches of points seen with both eyes improve this. Metres; any thread may call it.
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
    // m, root mean square of all components of the residuals, before and after the joint solution
    double before_rms = 0, after_rms = 0;
  };
  std::vector<Kind> kinds;
  double seconds = 0;
};

/// Solves all captures together. Throws Error in three cases: if there are no touches of the panel's marks, if one of
/// the eyes has no captures, or if the dots were recorded for no registration touch. The pose of the haptic base stays
/// bench.rig.X_WH, because X_WH defines W.
JointResult solve_jointly(const BenchState& bench, const Captures& captures);

}  // namespace typodont::calibration
