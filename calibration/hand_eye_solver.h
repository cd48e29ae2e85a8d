// Estimates two unknown poses: the pose X of a sensor on an arm, and the pose Z of its counterpart in the room. The
// input is pairs of poses A_i, B_i that the arm and a tracker report at the same times; the equation is A_i X = Z B_i.
// SI units. Not for real-time threads. Frames: H haptic base, S stylus, K camera or tracker, M marker or target.
//
// Robot–world: a marker M is on the stylus and a tracker K in the room. Then A = X_HS, B = X_KM, X = X_SM, Z = X_HK.
// Hand–eye: a camera K is on the stylus and a target M in the room. Then A = X_HS, B = X_MK (the inverse of the pose
// that the camera reports), X = X_SK, Z = X_HM. For relative motions (A_i X = X B_i), Z equals X.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

struct HandEyeOptions {
  bool motions = false;  // true: A and B are relative motions instead of poses, and the equation is A X = X B
  bool reject_outliers = true;
  double false_alarm = 5e-4;  // probability of rejecting at least one good pair (A_i, B_i)
};

struct HandEyeResult {
  Pose X, Z;  // solution of A X = Z B; for relative motions, Z equals X
  /// Row-major 6×6 covariance of the errors of X and Z: rotation vector θ (rad), then translation t (m). The errors
  /// change a pose (p, R) to (p + t, exp([θ]) R).
  std::array<double, 36> X_covariance{}, Z_covariance{};
  std::vector<std::size_t> inliers, outliers;  // indices of the pairs (A_i, B_i), ascending
  std::vector<double> rotation_residuals;      // rad, one per pair: angle between the rotations of A X and Z B
  std::vector<double> translation_residuals;   // m, one per pair: distance between the origins of the poses A X and Z B
  /// rad per axis, standard deviation of the noise of arm and tracker together
  double rotation_sigma = 0;
  /// m per axis, standard deviation of the noise of arm and tracker together
  double translation_sigma = 0;
  // rad, root mean square of the arm's rotations between the captured poses. main_turn: about the axis with the largest
  // rotations. second_turn: about the perpendicular axis with the next largest rotations.
  double main_turn = 0, second_turn = 0;
  std::string not_determined;  // reason why X and Z must not be used; empty: they can be used
};

/// Solves A X = Z B, first in closed form (Shah 2013, Kronecker product), then by maximum likelihood (Ceres). The 6×6
/// covariance of the noise is estimated from the residuals. Of n pairs, up to n/2 − 2 may be wrong in any way (least
/// trimmed squares, Rousseeuw & Van Driessen 2006). If there are fewer than eight pairs, no pair is rejected. Throws
/// Error if the lists differ in length or have fewer than 3 poses (2 motions).
HandEyeResult solve_hand_eye(std::span<const Pose> A, std::span<const Pose> B, const HandEyeOptions& options = {});

}  // namespace typodont::calibration
