// p_D = X_DH * p_H + isotropic noise (sigma per axis). Metres. Not for real time.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

/// Least squares of all pairs (at least one). Below 1 µs for 16 pairs, no allocation. If the rotation is open, one of
/// the best motions.
Pose fit_rigid(std::span<const dvec3> p_H, std::span<const dvec3> p_D) noexcept;

/// Reasons why a registration cannot be trusted.
enum class Defect {
  kNone,
  kCoincident,   // all points coincide: no rotation is determined
  kCollinear,    // rotation about the line is open
  kNoise,        // residuals as large as the points' spread
  kMirrored,     // D mirrors H
  kScaled,       // lengths in D and H differ: no rigid motion exists
  kNoConsensus,  // no set agrees better than by chance
};
const char* name(Defect defect);

/// What the points leave open.
struct Degeneracy {
  Defect defect = Defect::kNone;
  std::string reason;  // one sentence for the user
  // unit axes of open rotations
  std::vector<dvec3> undetermined_H;
};

struct Box {
  dvec3 low{0, 0, 0};
  // m, corners; both zero: the box of the inliers
  dvec3 high{0, 0, 0};
};

struct RegistrationOptions {
  bool reject_outliers = true;
  double known_sigma = 0;     // m per axis; 0: estimated
  Box workspace_H;            // m, box of predicted_tre_rms
  double false_alarm = 5e-4;  // probability of rejecting a good pair
};

/// Another motion that many pairs follow.
struct Rival {
  Pose X_DH;
  std::vector<std::size_t> pairs;
};

struct RegistrationResult {
  Pose X_DH;
  std::vector<std::size_t> inliers, outliers;  // indices of pairs, ascending
  std::vector<double> residuals;               // m, distance |X_DH p_H - p_D| for every pair
  double fre_rms = 0;                          // m, root mean square of the inliers' residuals (fiducial error)
  /// m per axis; NaN: cannot be estimated
  double sigma = 0;
  int degrees_of_freedom = 0;  // degrees of freedom of the estimate of sigma
  /// Row-major 6×6 in D: θ (rad), then t (m); errors change (p, R) to (p + t, exp([θ]) R). An open rotation has π²/3.
  std::array<double, 36> covariance{};
  // σ of the worst rotation / of the best; 1e16: open
  double condition = 1;
  double predicted_tre_rms = 0;  // m over the workspace
  dvec3 centroid_H{0, 0, 0};
  Degeneracy degeneracy;
  // other motions, largest group first; any: ambiguous
  std::vector<Rival> rivals;
  bool trusted() const { return degeneracy.defect == Defect::kNone && rivals.empty(); }
};

/// Robust, with uncertainty. Below half of the pairs may be wrong by anything (70 % if they disagree): as accurate as
/// if they were only noisy. Throws Error without pairs, or for unequal lists.
RegistrationResult register_points(std::span<const dvec3> p_H, std::span<const dvec3> p_D,
                                   const RegistrationOptions& options = {});

/// rms error at p_H, m.
double predicted_tre(const RegistrationResult& result, const dvec3& p_H);

/// The candidate that most reduces the mean squared target error.
std::size_t most_useful_touch(std::span<const dvec3> touched_H, std::span<const dvec3> candidates_H,
                              const Box& workspace_H);

}  // namespace typodont::calibration
