// Where a sensor sits on an arm, and where its partner stands, from poses that the arm and a tracker report at the same
// moments. SI; any thread; set-up time. Frames: H haptic base, S stylus, K camera or tracker, M marker or target.
//
// Robot–world: A_i X = Z B_i. A marker M on the stylus, a tracker K in the room: A = X_HS, B = X_KM, X = X_SM,
// Z = X_HK. Hand–eye: a camera K on the stylus, a target M in the room: the same equation with B = X_MK, the inverse of
// what the camera reports; X = X_SK, Z = X_HM. Of pure motions (A_i X = X B_i) Z is X.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

struct HandEyeOptions {
  bool motions = false;  // A and B are motions: A X = X B
  bool reject_outliers = true;
  double false_alarm = 5e-4;  // probability of rejecting any good row
};

struct HandEyeResult {
  Pose X, Z;  // of motions Z is X
  /// Row-major 6×6 of (rotation vector, rad; translation, m), as in RegistrationResult: X = (exp([θ]) R, p + t).
  std::array<double, 36> X_covariance{}, Z_covariance{};
  std::vector<std::size_t> inliers, outliers;  // rows, ascending
  std::vector<double> rotation_residuals;      // rad, of every row
  std::vector<double> translation_residuals;   // m, of every row, at the origin of B's moving frame
  double rotation_sigma = 0;                   // rad per axis, of arm and tracker together
  double translation_sigma = 0;                // m per axis
  double main_turn = 0, second_turn = 0;       // rad rms: how far the arm turned about its main and second axis
  std::string not_determined;                  // not empty: why X and Z must not be used
};

/// Closed form (Shah 2013, Kronecker product), then maximum likelihood (Ceres) with the 6×6 covariance of the noise
/// estimated from the residuals. Fewer than half of the rows, less two, may be wrong in any way (least trimmed squares,
/// Rousseeuw & Van Driessen 2006); of fewer than eight rows none is rejected. Throws Error where the lists differ in
/// length or hold fewer than 3 poses (2 motions).
HandEyeResult solve_hand_eye(std::span<const Pose> A, std::span<const Pose> B, const HandEyeOptions& options = {});

}  // namespace typodont::calibration
