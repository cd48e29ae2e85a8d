// Rigid registration of paired points: the pose of the haptic base H relative to the display D. Model: p_D = X_DH * p_H
// + noise; the noise is isotropic with standard deviation sigma per axis. Metres. Not for real-time threads.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

/// Returns the least-squares rigid motion of all pairs, without a search for outliers. Takes less than a microsecond
/// for 16 pairs and never allocates. Needs at least one pair. If the points do not determine the rotation, several
/// motions fit equally well, and one of them is returned.
Pose fit_rigid(std::span<const dvec3> p_H, std::span<const dvec3> p_D) noexcept;

/// Reasons why a registration cannot be trusted.
enum class Defect {
  kNone,
  kCoincident,   // all points coincide: no rotation is determined
  kCollinear,    // all points lie on a line: the rotation about this line is not determined
  kNoise,        // the residuals are as large as the spread of the points
  kMirrored,     // the points in D are a mirror image of those in H: no rigid motion exists
  kScaled,       // lengths in D and H differ: no rigid motion exists
  kNoConsensus,  // no set of pairs agrees on a motion better than by chance
};
const char* name(Defect defect);

/// Describes which part of the rigid motion the points do not determine: as a text, and as directions in frame H of the
/// haptic base.
struct Degeneracy {
  Defect defect = Defect::kNone;
  std::string reason;  // one sentence for the user: what the points do not determine
  // unit axes, in frame H of the haptic base, of the rotations that the points do not determine
  std::vector<dvec3> undetermined_H;
};

struct Box {
  dvec3 low{0, 0, 0};
  // m; `low` and `high` are corners of the box; if both are zero, the bounding box of the inliers is used
  dvec3 high{0, 0, 0};
};

struct RegistrationOptions {
  bool reject_outliers = true;
  double known_sigma = 0;     // m per axis, known noise; 0: the noise is estimated from the residuals
  Box workspace_H;            // m, frame H of the haptic base: box over which predicted_tre_rms is averaged
  double false_alarm = 5e-4;  // probability of rejecting at least one good pair of the set
};

/// A rigid motion, other than the result, with which many of the pairs agree.
struct Rival {
  Pose X_DH;
  std::vector<std::size_t> pairs;
};

struct RegistrationResult {
  Pose X_DH;
  std::vector<std::size_t> inliers, outliers;  // indices of pairs, ascending
  std::vector<double> residuals;               // m, distance |X_DH p_H - p_D| for every pair
  double fre_rms = 0;                          // m, root mean square of the inliers' residuals (fiducial error)
  /// m per axis, standard deviation of the noise; NaN if it cannot be estimated
  double sigma = 0;
  int degrees_of_freedom = 0;  // degrees of freedom of the estimate of sigma
  /// Row-major 6×6 covariance of the errors of X_DH in frame D (display): rotation vector θ (rad), then translation t
  /// (m). The errors change the pose (p, R) to (p + t, exp([θ]) R). An undetermined rotation has the variance of a
  /// uniform angle, π²/3.
  std::array<double, 36> covariance{};
  // condition number: uncertainty of the worst determined rotation divided by that of the best determined rotation;
  // 1e16 if a rotation is undetermined
  double condition = 1;
  double predicted_tre_rms = 0;  // m, root mean square of the predicted target error over the workspace
  dvec3 centroid_H{0, 0, 0};
  Degeneracy degeneracy;
  // other motions that each fit a group of the pairs, largest group first; if there are any, the result is ambiguous
  std::vector<Rival> rivals;
  bool trusted() const { return degeneracy.defect == Defect::kNone && rivals.empty(); }
};

/// Registers pairs of points robustly, with uncertainty and outlier detection. Fewer than half of the pairs may have
/// errors of any size: the result is then at least as accurate as if these errors were only as large as the noise. If
/// the wrong pairs do not agree with each other, up to 70 % of the pairs may be wrong. Throws Error if there is no
/// pair, or if the two lists differ in length.
RegistrationResult register_points(std::span<const dvec3> p_H, std::span<const dvec3> p_D,
                                   const RegistrationOptions& options = {});

/// Returns the expected rms error (m) of the registration at the point p_H (m, frame H of the haptic base).
double predicted_tre(const RegistrationResult& result, const dvec3& p_H);

/// Returns the index of the candidate point that should be touched next: its touch would most reduce the mean squared
/// target error (TRE) over the workspace.
std::size_t most_useful_touch(std::span<const dvec3> touched_H, std::span<const dvec3> candidates_H,
                              const Box& workspace_H);

}  // namespace typodont::calibration
