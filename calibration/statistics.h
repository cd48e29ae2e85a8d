// Quantiles of distributions, and seeded normally distributed random numbers.
#pragma once

#include <cstdint>
#include <random>

#include "engine/base/pose.h"

namespace typodont::calibration {

/// P(X <= x) of the chi-squared distribution.
double chi_squared_cdf(double x, double dof);
/// x with P(X <= x) = p, chi-squared distribution.
double chi_squared_quantile(double p, double dof);
/// The quantile x with P(X <= x) = p of the distribution F(d1, d2).
double f_quantile(double p, double d1, double d2);

/// Random numbers; the same seed gives the same numbers.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  double normal(double sigma = 1) { return sigma * normal_(engine_); }
  dvec3 normal3(double sigma);
  dvec3 in_box(const dvec3& low, const dvec3& high);
  dquat rotation();  // returns a random rotation; all rotations are equally probable
  std::size_t index(std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(engine_); }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

}  // namespace typodont::calibration
