// Finds pairs of points that agree on a rigid motion; used by the registration.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "calibration/registration_solver.h"
#include "engine/base/split_mix.h"

namespace typodont::calibration {

using Points = std::span<const dvec3>;
using Indices = std::vector<std::size_t>;

/// Rigid motion fitted to some pairs.
struct Fit {
  Pose X_DH;
  Indices pairs;   // indices of the pairs, ascending
  double sse = 0;  // m², sum of the squared residuals
};
Fit fit_to(Points p_H, Points p_D, Indices pairs);

/// Noise of a fit per axis, m; needs at least four pairs.
double sigma_of(const Fit& fit);

/// Number of pairs with a residual of at most `limit` (m) under X_DH.
std::size_t followers(Points p_H, Points p_D, const Pose& X_DH, double limit);

/// Random number below `count`. Seeding a generator of the standard library would take longer than a search.
inline std::size_t random_index(SplitMix64& random, std::size_t count) {
  return static_cast<std::size_t>((random.next() >> 32) * count >> 32);
}

/// Estimated rounding error of the coordinates, m.
double rounding_of(Points p_H, Points p_D);

struct Agreement {
  Fit fit;
  // Logarithm of the number of equally good sets of pairs that is expected by chance.
  double log_nfa = std::numeric_limits<double>::infinity();
};
/// Finds the largest set of agreeing pairs. With known noise, sets smaller than `least` may be missed.
Agreement max_agreement(Points p_H, Points p_D, const RegistrationOptions& options, std::size_t least);

}  // namespace typodont::calibration
