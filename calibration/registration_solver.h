// Finds the motion X_DH of points: p_D = X_DH * p_H + isotropic noise (sigma per axis). Metres. Not for real time.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

/// Rigid motion from p_H to p_D with the least squared error over all pairs (at least one). Takes below 1 µs for 16
/// pairs. If the points do not determine the rotation, returns one of the best motions.
Pose fit_rigid(std::span<const dvec3> p_H, std::span<const dvec3> p_D) noexcept;

/// Reasons why a registration cannot be trusted.
enum class Defect {
  kNone,
  kCoincident,   // all points coincide: no rotation is determined
  kCollinear,    // the rotation about the line is not determined
  kNoise,        // the residuals are as large as the points' spread
  kMirrored,     // the points p_D are a mirror image of p_H
  kScaled,       // distances between points differ in D and H: no rigid motion exists
  kNoConsensus,  // no set of pairs agrees better than by chance
};
const char* name(Defect defect);

/// Whether the points determine all rotations of the motion.
struct Degeneracy {
  Defect defect = Defect::kNone;
  std::string reason;  // one sentence for the user
  // Unit axes of rotations that are not determined.
  std::vector<dvec3> undetermined_H;
};

struct Box {
  dvec3 low{0, 0, 0};
  // Corners of the box, m; both zero: the bounding box of the inliers.
  dvec3 high{0, 0, 0};
};

struct RegistrationOptions {
  bool reject_outliers = true;
  double known_sigma = 0;     // m per axis, known noise; 0: estimated
  Box workspace_H;            // m, box in which predicted_tre_rms is computed
  double false_alarm = 5e-4;  // probability of rejecting at least one good pair
};

/// Another rigid motion with which many pairs agree; it makes the registration ambiguous.
struct Rival {
  Pose X_DH;
  std::vector<std::size_t> pairs;
};

struct RegistrationResult {
  Pose X_DH;
  std::vector<std::size_t> inliers, outliers;  // indices of the pairs, ascending
  std::vector<double> residuals;               // m, distance |X_DH p_H - p_D| for every pair
  double fre_rms = 0;                          // m, root mean square of the inliers' residuals (fiducial error)
  /// Noise per axis, m; NaN if it cannot be estimated.
  double sigma = 0;
  int degrees_of_freedom = 0;  // degrees of freedom of the estimate of sigma
  /// Covariance of X_DH in frame D, 6×6, row-major: θ (rad), then t (m); errors change (p, R) to (p + t, exp([θ]) R). A
  /// rotation that is not determined has the variance π²/3.
  std::array<double, 36> covariance{};
  // Ratio of the standard deviations of the least and the most certain rotation; 1e16: a rotation is not determined.
  double condition = 1;
  double predicted_tre_rms = 0;  // m, predicted target error over the workspace
  dvec3 centroid_H{0, 0, 0};
  Degeneracy degeneracy;
  // Other rigid motions that fit many pairs, the one with most pairs first. If not empty, X_DH is ambiguous.
  std::vector<Rival> rivals;
  bool trusted() const { return degeneracy.defect == Defect::kNone && rivals.empty(); }
};

/// Robust registration with uncertainty. Up to half of the pairs may be wrong by any amount (up to 70 % if the wrong
/// pairs do not agree with each other). Throws Error without pairs, or for lists of unequal length.
RegistrationResult register_points(std::span<const dvec3> p_H, std::span<const dvec3> p_D,
                                   const RegistrationOptions& options = {});

/// Predicted rms error at p_H, m.
double predicted_tre(const RegistrationResult& result, const dvec3& p_H);

/// Index of the candidate that most reduces the mean squared target error.
std::size_t most_useful_touch(std::span<const dvec3> touched_H, std::span<const dvec3> candidates_H,
                              const Box& workspace_H);

}  // namespace typodont::calibration
