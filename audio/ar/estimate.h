// Estimates autoregressive models from samples. Pure functions in double precision.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace typodont::audio {

struct Estimate {
  std::vector<double> reflection;
  double variance = 0;  // variance of the prediction residual
  // Variances of the prediction residual for the orders 0…p; may be empty.
  std::vector<double> by_order;
  /// True: the solution was unstable, and was replaced by the stable model with the same spectrum.
  bool refactored = false;
};

/// Burg's method (1975). `weights`: optional, per sample (Swingler 1979). Always stable.
Estimate burg(std::span<const double> x, std::size_t order, std::span<const double> weights = {});
/// Yule–Walker method: Levinson–Durbin on the biased autocorrelation of the samples × `taper`. Always stable.
Estimate yule_walker(std::span<const double> x, std::size_t order, std::span<const double> taper = {});
/// Modified covariance (Marple 1980): least squares of forward and backward prediction. Sets Estimate::refactored.
Estimate modified_covariance(std::span<const double> x, std::size_t order);

enum class Criterion { kAkaike, kBayes };
/// Returns the order p with the smallest criterion: n·ln σ²_p + 2p (Akaike 1974) or n·ln σ²_p + p·ln n (Schwarz 1978),
/// for n samples.
std::size_t best_order(const std::vector<double>& variance_by_order, std::size_t samples, Criterion criterion);

}  // namespace typodont::audio
