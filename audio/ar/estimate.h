// Autoregressive models from samples. Pure functions, double precision.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace typodont::audio {

struct Estimate {
  std::vector<double> reflection;
  double variance = 0;  // variance of the residual
  // the same for order 0…p; may be empty
  std::vector<double> by_order;
  /// unstable solution replaced by the stable model of the same spectrum
  bool refactored = false;
};

/// Burg 1975, optionally weighted (Swingler 1979; weights.size() == x.size()). Stable.
Estimate burg(std::span<const double> x, std::size_t order, std::span<const double> weights = {});
/// Yule–Walker: Levinson–Durbin on the biased autocorrelation of the tapered samples. Stable.
Estimate yule_walker(std::span<const double> x, std::size_t order, std::span<const double> taper = {});
/// Modified covariance (Marple 1980): least squares of forward and backward prediction. Sets `refactored`.
Estimate modified_covariance(std::span<const double> x, std::size_t order);

enum class Criterion { kAkaike, kBayes };
/// Order p with the least n·ln σ²_p + 2p (Akaike 1974) or n·ln σ²_p + p·ln n (Schwarz 1978); n samples.
std::size_t best_order(const std::vector<double>& variance_by_order, std::size_t samples, Criterion criterion);

}  // namespace typodont::audio
