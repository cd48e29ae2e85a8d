// The user's eyes: the tip covers a dot shown to one eye, so eye, tip and dot are on a line. W, m; any thread.
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

/// Touch of a point seen with both eyes.
struct SeenTouch {
  dvec3 shown_W{0, 0, 0}, touched_W{0, 0, 0};
};

/// Felt minus seen position.
struct UserOffset {
  // m, and its σ
  dvec3 W{0, 0, 0}, sigma{0, 0, 0};
  int touches = 0, rejected = 0;
};

struct EyesResult {
  EyePair eyes;
  std::array<double, 3> center_sigma{};  // m per axis, standard deviation of the eyes' centre
  double ipd_sigma = 0;                  // m, standard deviation of the interpupillary distance
  // m across the line of sight: noise; rms residual
  double sigma = 0, rms = 0;
  std::vector<std::size_t> rejected;      // indices of the rejected alignments of tip and dot
  std::vector<double> residuals;          // m, residual of each alignment of tip and dot
  std::string not_determined;             // what the alignments leave open; empty: nothing
  std::optional<UserOffset> user_offset;  // the user's offset, if it was requested
};

/// Initial eyes from `rig`, with panel and mirror.
EyesResult solve_eyes(std::span<const EyeAlignment> alignments, const RigGeometry& rig);

/// Mean of touched minus seen, without outliers (by the median). Two touches or more. A displaced base looks the same
/// (joint_solver.h tells them apart).
UserOffset user_offset_of(std::span<const SeenTouch> touches);

}  // namespace typodont::calibration
