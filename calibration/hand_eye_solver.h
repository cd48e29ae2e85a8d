// Solves A_i X = Z B_i: X is the pose of a sensor on an arm, Z the pose of its counterpart in the room. SI units. Not
// for real time. Frames: H haptic base, S stylus, K camera or tracker, M marker or target.
//
// Robot–world (marker on the stylus): A = X_HS, B = X_KM, X = X_SM, Z = X_HK.
// Hand–eye (camera on the stylus): A = X_HS, B = X_MK (inverse of the reported pose), X = X_SK, Z = X_HM.
// Relative motions (A_i X = X B_i): Z equals X.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

struct HandEyeOptions {
  bool motions = false;  // true: A and B are relative motions, AX = XB
  bool reject_outliers = true;
  double false_alarm = 5e-4;  // probability of rejecting at least one good pair (A_i, B_i)
};

struct HandEyeResult {
  Pose X, Z;  // for motions, Z equals X
  /// Covariances, 6×6, row-major: θ (rad), then t (m); errors change (p, R) to (p + t, exp([θ]) R).
  std::array<double, 36> X_covariance{}, Z_covariance{};
  std::vector<std::size_t> inliers, outliers;  // indices of the pairs (A_i, B_i), ascending
  std::vector<double> rotation_residuals;      // rad, angle between A X and Z B
  std::vector<double> translation_residuals;   // m, distance between A X and Z B
  /// Rotation noise per axis, arm and tracker together, rad.
  double rotation_sigma = 0;
  /// Translation noise per axis, arm and tracker together, m.
  double translation_sigma = 0;
  // Rms rotation of the arm about its main axis, and about the next axis perpendicular to it, rad.
  double main_turn = 0, second_turn = 0;
  std::string not_determined;  // reason why X and Z must not be used; empty: they can be used
};

/// Closed form (Shah 2013), then maximum likelihood (Ceres) with a 6×6 noise covariance from the residuals. Of n pairs,
/// n/2 − 2 may be wrong (least trimmed squares, Rousseeuw & Van Driessen 2006); below eight pairs, none is rejected.
/// Throws Error for lists of unequal length, or fewer than 3 poses (2 motions).
HandEyeResult solve_hand_eye(std::span<const Pose> A, std::span<const Pose> B, const HandEyeOptions& options = {});

}  // namespace typodont::calibration
