// Autoregressive models from samples. Pure functions, double precision.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace typodont::audio {

struct Estimate {
  std::vector<double> reflection;
  double variance = 0;  // variance of the prediction residual (the part of the sound that the model does not predict)
  // variance of the residual for each order 0…p, from which a criterion chooses the order; may be empty
  std::vector<double> by_order;
  /// true if the solution was unstable and was replaced by the stable model with the same spectrum
  bool refactored = false;
};

/// Fits a model by Burg's method (Burg 1975). `weights`, if not empty, weight the prediction errors (Swingler 1979);
/// weights.size() == x.size(). The result is stable by construction.
Estimate burg(std::span<const double> x, std::size_t order, std::span<const double> weights = {});
/// Fits a model by the Yule–Walker method: Levinson–Durbin on the biased autocorrelation of the (tapered) samples. The
/// result is stable by construction.
Estimate yule_walker(std::span<const double> x, std::size_t order, std::span<const double> taper = {});
/// Fits a model by the modified covariance method (Marple 1980): least squares of forward and backward prediction. An
/// unstable solution is replaced by the stable model with the same spectrum, and `refactored` is set.
Estimate modified_covariance(std::span<const double> x, std::size_t order);

enum class Criterion { kAkaike, kBayes };
/// Returns the order p that minimises n·ln σ²_p + 2p (Akaike 1974) or n·ln σ²_p + p·ln n (Schwarz 1978). n: number of
/// samples; σ²_p: variance of the prediction residual at order p.
std::size_t best_order(const std::vector<double>& variance_by_order, std::size_t samples, Criterion criterion);

}  // namespace typodont::audio
