// Which pairs of points agree on one rigid motion. Only for the registration.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "calibration/registration_solver.h"

namespace typodont::calibration {

using Points = std::span<const dvec3>;
using Indices = std::vector<std::size_t>;

/// The least-squares motion of some of the pairs.
struct Fit {
  Pose X_DH;
  Indices pairs;   // ascending
  double sse = 0;  // m²
};
Fit fit_to(Points p_H, Points p_D, Indices pairs);

/// m per axis, the noise that a fit of four pairs or more leaves over.
double sigma_of(const Fit& fit);

/// How many of all pairs lie within `limit` m of where the motion takes them.
std::size_t followers(Points p_H, Points p_D, const Pose& X_DH, double limit);

/// m, what doubles can tell of the points.
double rounding_of(Points p_H, Points p_D);

/// The largest set of pairs that agree, and how often chance alone brings as many together.
struct Agreement {
  Fit fit;
  double log_nfa = std::numeric_limits<double>::infinity();  // the logarithm of the number of false alarms
};
/// Where the noise is known, sets smaller than `least` need not be found.
Agreement largest_agreement(Points p_H, Points p_D, const RegistrationOptions& options, std::size_t least);

}  // namespace typodont::calibration
