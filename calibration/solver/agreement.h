// Finds the pairs of points that agree on one rigid motion. Only for the registration.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "calibration/registration_solver.h"

namespace typodont::calibration {

using Points = std::span<const dvec3>;
using Indices = std::vector<std::size_t>;

/// A least-squares rigid motion for some of the pairs of points.
struct Fit {
  Pose X_DH;
  Indices pairs;   // indices of the pairs, ascending
  double sse = 0;  // m², sum of the squared residuals
};
Fit fit_to(Points p_H, Points p_D, Indices pairs);

/// Returns the noise per axis (m), estimated from the residuals of a fit of at least four pairs.
double sigma_of(const Fit& fit);

/// Returns the number of pairs whose residual under the motion X_DH is at most `limit` (m).
std::size_t followers(Points p_H, Points p_D, const Pose& X_DH, double limit);

/// Returns the rounding error (m) of the points' coordinates in double precision.
double rounding_of(Points p_H, Points p_D);

/// The largest set of agreeing pairs, and the expected number of equally good sets that arise by chance.
struct Agreement {
  Fit fit;
  // logarithm of the expected number of equally good sets by chance
  double log_nfa = std::numeric_limits<double>::infinity();
};
/// Finds the largest set of agreeing pairs. If the noise is known, the search may miss sets of fewer than `least`
/// pairs.
Agreement largest_agreement(Points p_H, Points p_D, const RegistrationOptions& options, std::size_t least);

}  // namespace typodont::calibration
