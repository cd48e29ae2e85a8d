// All captures at once: arm, panel, mirror, eyes and the user's offset explain every touch together. The single steps
// give the start; this takes out what each passes on to the next (an eye is known to millimetres from alignments alone,
// and to what matters from the touches of points seen with both). Metres; any thread.
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
  dvec3 user_offset_W{0, 0, 0}, user_offset_sigma{0, 0, 0};  // m, felt minus seen
  dvec3 eye_center_sigma{0, 0, 0};                           // m
  double ipd_sigma = 0;                                      // m
  struct Kind {
    std::string name;
    int touches = 0, rejected = 0;
    double before_rms = 0, after_rms = 0;  // m, per residual component
  };
  std::vector<Kind> kinds;
  double seconds = 0;
};

/// Needs panel marks, alignments of both eyes and registration touches whose dots were recorded; throws Error without.
/// The haptic base stays where bench.rig.X_WH says: it defines W.
JointResult solve_jointly(const BenchState& bench, const Captures& captures);

}  // namespace typodont::calibration
