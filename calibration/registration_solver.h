// Rigid registration of paired points: where the haptic base H is, as seen from the display D.
// p_D = X_DH * p_H + noise, isotropic with standard deviation sigma per axis. Metres; any thread; set-up time.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

/// The least-squares rigid motion of all pairs, nothing else: under a microsecond for 16 pairs, never allocates.
/// At least one pair. Where the points do not determine the rotation it returns one of the best.
Pose fit_rigid(std::span<const dvec3> p_H, std::span<const dvec3> p_D) noexcept;

/// Why a registration cannot be trusted.
enum class Defect {
  kNone,
  kCoincident,   // all points in one place: no rotation is determined
  kCollinear,    // on one line: the turn about it is not determined
  kNoise,        // the residuals are as large as the spread of the points
  kMirrored,     // D is a mirror image of H: no rigid motion exists
  kScaled,       // lengths in D and H differ: no rigid motion exists
  kNoConsensus,  // no set of pairs agrees on a motion better than chance
};
const char* name(Defect defect);

/// What the points leave open, in words and as directions in H.
struct Degeneracy {
  Defect defect = Defect::kNone;
  std::string reason;                 // one sentence for people
  std::vector<dvec3> undetermined_H;  // unit axes of the rotations that are not determined
};

struct Box {
  dvec3 low{0, 0, 0};
  dvec3 high{0, 0, 0};  // both zero: the bounding box of the inliers
};

struct RegistrationOptions {
  bool reject_outliers = true;
  double known_sigma = 0;     // m per axis; 0: estimated from the residuals
  Box workspace_H;            // where predicted_tre_rms is averaged
  double false_alarm = 5e-4;  // probability of rejecting any good pair of the set
};

/// Another motion that a good part of the pairs agrees on.
struct Rival {
  Pose X_DH;
  std::vector<std::size_t> pairs;
};

struct RegistrationResult {
  Pose X_DH;
  std::vector<std::size_t> inliers, outliers;  // indices of pairs, ascending
  std::vector<double> residuals;               // m, |X_DH p_H - p_D| of every pair
  double fre_rms = 0;                          // m, over the inliers
  double sigma = 0;                            // m per axis; NaN when nothing determines it
  int degrees_of_freedom = 0;                  // behind sigma
  /// Row-major 6×6 of (rotation vector, rad; translation, m), both expressed in D: X = (exp([θ]) R, p + t). A rotation
  /// that is not determined has the variance of a uniform angle, π²/3.
  std::array<double, 36> covariance{};
  double condition = 1;          // ratio of the worst to the best determined rotation; 1e16 when one is not determined
  double predicted_tre_rms = 0;  // m, over the workspace
  dvec3 centroid_H{0, 0, 0};
  Degeneracy degeneracy;
  std::vector<Rival> rivals;  // largest first; not empty: the pairs are ambiguous
  bool trusted() const { return degeneracy.defect == Defect::kNone && rivals.empty(); }
};

/// The registration with its uncertainty, and with outliers set aside. Breakdown: fewer than half of the pairs, wrong
/// in any way, move the result by no more than wrong pairs within the noise do; scattered ones may be up to 70 %.
/// Throws Error when there is no pair, or the two lists differ in length.
RegistrationResult register_points(std::span<const dvec3> p_H, std::span<const dvec3> p_D,
                                   const RegistrationOptions& options = {});

/// m, expected rms error of the registration at a point of H.
double predicted_tre(const RegistrationResult& result, const dvec3& p_H);

/// The candidate (an index) whose touch would reduce the mean squared TRE over the workspace most.
std::size_t most_useful_touch(std::span<const dvec3> touched_H, std::span<const dvec3> candidates_H,
                              const Box& workspace_H);

}  // namespace typodont::calibration
