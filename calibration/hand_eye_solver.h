// A_i X = Z B_i: pose X of a sensor on an arm, pose Z of its counterpart in the room. SI. Not for real time.
// Frames: H haptic base, S stylus, K camera or tracker, M marker or target.
//
// Robot–world (marker on the stylus): A = X_HS, B = X_KM, X = X_SM, Z = X_HK.
// Hand–eye (camera on the stylus): A = X_HS, B = X_MK (inverse of the report), X = X_SK, Z = X_HM.
// Relative motions (A_i X = X B_i): Z equals X.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

struct HandEyeOptions {
  bool motions = false;  // A and B are relative motions: A X = X B
  bool reject_outliers = true;
  double false_alarm = 5e-4;  // probability of rejecting at least one good pair (A_i, B_i)
};

struct HandEyeResult {
  Pose X, Z;  // for motions, Z equals X
  /// Row-major 6×6: θ (rad), then t (m); errors change (p, R) to (p + t, exp([θ]) R).
  std::array<double, 36> X_covariance{}, Z_covariance{};
  std::vector<std::size_t> inliers, outliers;  // indices of the pairs (A_i, B_i), ascending
  std::vector<double> rotation_residuals;      // rad, angle between A X and Z B
  std::vector<double> translation_residuals;   // m, distance between A X and Z B
  /// rad per axis, arm and tracker together
  double rotation_sigma = 0;
  /// m per axis, arm and tracker together
  double translation_sigma = 0;
  // rad, rms of the arm's rotations about the main and the next perpendicular axis
  double main_turn = 0, second_turn = 0;
  std::string not_determined;  // why not to use X and Z; empty: usable
};

/// Closed form (Shah 2013), then maximum likelihood (Ceres) with a 6×6 noise covariance from the residuals. Of n pairs,
/// n/2 − 2 may be wrong (least trimmed squares, Rousseeuw & Van Driessen 2006); none is rejected below eight. Throws
/// Error for unequal lists, or below 3 poses (2 motions).
HandEyeResult solve_hand_eye(std::span<const Pose> A, std::span<const Pose> B, const HandEyeOptions& options = {});

}  // namespace typodont::calibration
