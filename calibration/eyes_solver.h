// Where a user's eyes are: a dot is shown to one eye at a time, and the user holds the stylus tip so that it covers the
// dot. Eye, tip and dot then lie on one line. Frame W; metres; any thread.
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
  dvec3 p_W{0, 0, 0};  // the stylus tip
};

/// A touch of a point seen with both eyes, for the user's own offset between seeing and feeling.
struct SeenTouch {
  dvec3 shown_W{0, 0, 0}, touched_W{0, 0, 0};
};

/// By how much one user systematically feels beside what is seen.
struct UserOffset {
  dvec3 W{0, 0, 0}, sigma{0, 0, 0};  // m, touched minus seen
  int touches = 0, rejected = 0;
};

struct EyesResult {
  EyePair eyes;
  std::array<double, 3> center_sigma{};  // m
  double ipd_sigma = 0;                  // m
  double sigma = 0, rms = 0;             // m, across the line of sight
  std::vector<std::size_t> rejected;
  std::vector<double> residuals;          // m
  std::string not_determined;             // empty: all of it is
  std::optional<UserOffset> user_offset;  // where it was asked for
};

/// `rig` holds the panel and the mirror; its eyes are where the search starts.
EyesResult solve_eyes(std::span<const EyeAlignment> alignments, const RigGeometry& rig);

/// The mean of touched minus seen, slips set aside by the median. At least two touches. What a shifted base does looks
/// the same: the base must be known from elsewhere (joint_solver.h tells the two apart).
UserOffset user_offset_of(std::span<const SeenTouch> touches);

}  // namespace typodont::calibration
