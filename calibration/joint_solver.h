// Fits arm, panel, mirror, eyes and user offset (felt minus seen position) to all touches at once, so errors of one
// step do not spread. A bent panel, a curved mirror and a slipped tip are included if the touches show them. Touches
// seen with both eyes locate eyes better than alignments with one eye. Metres; any thread.
#pragma once

#include <string>
#include <vector>

#include "calibration/routine.h"

namespace typodont::calibration {

inline constexpr const char* kMirrorCurved = "mirror curved";

struct JointResult {
  ArmGeometry arm;
  Panel panel;
  std::optional<MirrorPlane> mirror;
  EyePair eyes;
  /// m, position felt minus position seen, frame W of this solution, and its standard deviation
  dvec3 user_offset_W{0, 0, 0}, user_offset_sigma{0, 0, 0};
  dvec3 eye_center_sigma{0, 0, 0};  // m, standard deviation of the eyes' centre
  double ipd_sigma = 0;             // m, standard deviation of the interpupillary distance
  struct Kind {
    std::string name;
    int touches = 0, rejected = 0;
    // Rms of the residuals of all touches, per component, before and after the solution, m.
    double before_rms = 0, after_rms = 0;
  };
  std::vector<Kind> kinds;
  /// A part of the model that the touches show: bend of the panel and slips of the tip in m, curvature in 1/m.
  struct Term {
    std::string name;
    dvec3 value{0, 0, 0}, sigma{0, 0, 0};
    double evidence = 0;  // Wald's chi-squared with 3 degrees of freedom
  };
  std::vector<Term> terms;
  double seconds = 0;
};

/// A term's size, for people: "(0.44, -0.35, 0.58) ± (0.07, 0.05, 0.14) mm".
std::string size_in_words(const JointResult::Term& term);

/// Throws Error if there are too few captures of one kind: touches of marks, alignments with one eye, or touches for
/// which both eyes' dots were recorded. X_WH does not change, because X_WH defines the frame W.
JointResult solve_jointly(const BenchState& bench, const Captures& captures);

}  // namespace typodont::calibration
