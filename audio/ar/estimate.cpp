#include "audio/ar/estimate.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "audio/ar/levinson.h"
#include "audio/ar/spectrum.h"

namespace typodont::audio {

Estimate burg(std::span<const double> x, std::size_t order, std::span<const double> weights) {
  const std::size_t n = x.size();
  Estimate result;
  double power = 0, weight = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double w = weights.empty() ? 1.0 : weights[i];
    power += w * x[i] * x[i];
    weight += w;
  }
  double variance = power / weight;
  result.by_order.push_back(variance);
  // Pass m of Burg's method. At its start, forward[i] and backward[i] are the prediction errors of order m at the
  // samples m + 1 + i and m + i.
  std::vector<double> forward(x.begin() + 1, x.end()), backward(x.begin(), x.end() - 1);
  for (std::size_t m = 0; m < order; ++m) {
    const std::size_t count = n - m - 1;
    double cross = 0, energy = 0;
    if (weights.empty()) {
      for (std::size_t i = 0; i < count; ++i) {
        cross += forward[i] * backward[i];
        energy += forward[i] * forward[i] + backward[i] * backward[i];
      }
    } else {
      // The two prediction errors use the samples i … i + m + 1; their weight is the weight of the middle sample.
      const std::size_t middle = (m + 1) / 2;
      for (std::size_t i = 0; i < count; ++i) {
        const double w = weights[i + middle];
        cross += w * forward[i] * backward[i];
        energy += w * (forward[i] * forward[i] + backward[i] * backward[i]);
      }
    }
    // |k| ≤ 1, because |2fb| ≤ f² + b² for the forward error f and the backward error b.
    const double k = energy > 0 ? -2 * cross / energy : 0.0;
    result.reflection.push_back(k);
    variance *= 1 - k * k;
    result.by_order.push_back(variance);
    for (std::size_t i = 0; i + 1 < count; ++i) {
      const double f = forward[i + 1] + k * backward[i + 1];
      backward[i] = backward[i] + k * forward[i];
      forward[i] = f;
    }
  }
  result.variance = variance;
  return result;
}

Estimate yule_walker(std::span<const double> x, std::size_t order, std::span<const double> taper) {
  std::vector<double> tapered(x.begin(), x.end());
  double scale = 1;
  if (!taper.empty()) {
    double weight = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      tapered[i] *= taper[i];
      weight += taper[i] * taper[i];
    }
    scale = static_cast<double>(x.size()) / weight;
  }
  auto r = autocorrelation(tapered, order);
  for (double& v : r) v *= scale;
  Estimate result;
  result.reflection = reflection_of_autocorrelation(r);
  double variance = r[0];
  result.by_order.push_back(variance);
  for (const double k : result.reflection) result.by_order.push_back(variance *= 1 - k * k);
  result.variance = variance;
  return result;
}

Estimate modified_covariance(std::span<const double> x, std::size_t order) {
  const std::size_t n = x.size(), p = order;
  const auto lag = [&](std::size_t m, std::size_t i) { return x[m - i]; };
  // c(i,j) = Σ_{m=p}^{n−1} x[m−i] x[m−j]. Only the first row is summed; every other element follows from its upper left
  // neighbour.
  const auto size = static_cast<Eigen::Index>(p + 1);
  Eigen::MatrixXd c(size, size);
  for (std::size_t j = 0; j <= p; ++j) {
    double sum = 0;
    for (std::size_t m = p; m < n; ++m) sum += x[m] * lag(m, j);
    c(0, static_cast<Eigen::Index>(j)) = sum;
  }
  for (std::size_t i = 0; i < p; ++i) {
    for (std::size_t j = i; j < p; ++j) {
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(j);
      c(row + 1, column + 1) = c(row, column) + x[p - 1 - i] * x[p - 1 - j] - x[n - 1 - i] * x[n - 1 - j];
    }
  }
  c.triangularView<Eigen::StrictlyLower>() = c.transpose();
  // Normal equations of forward and backward prediction together.
  const Eigen::MatrixXd both = c + c.reverse();

  const auto order_index = static_cast<Eigen::Index>(p);
  const Eigen::VectorXd right = -both.col(0).tail(order_index);
  const Eigen::VectorXd solution = both.bottomRightCorner(order_index, order_index).ldlt().solve(right);
  const double error = both(0, 0) + both.row(0).tail(order_index).dot(solution);

  Estimate result;
  result.variance = std::max(error, 0.0) / (2 * static_cast<double>(n - p));
  result.reflection = step_down(std::vector<double>(solution.data(), solution.data() + solution.size()));
  const bool stable =
      std::all_of(result.reflection.begin(), result.reflection.end(), [](double k) { return std::abs(k) < 1; });
  if (!stable) {
    // Replaces an unstable model by the stable model with the same spectrum, by autocorrelation and Levinson–Durbin.
    constexpr std::size_t kPoints = (std::size_t{1} << 16) + 1;
    std::vector<double> power(kPoints);
    const auto denominator = power_of_taps({solution.data(), p}, kPoints);
    for (std::size_t i = 0; i < kPoints; ++i) power[i] = result.variance / std::max(denominator[i], 1e-30);
    double gain = 0;
    result.reflection = reflection_of_power(power, p, gain);
    result.variance = gain * gain;
    result.refactored = true;
  }
  return result;
}

std::size_t best_order(const std::vector<double>& variance_by_order, std::size_t samples, Criterion criterion) {
  const double n = static_cast<double>(samples);
  const double cost = criterion == Criterion::kAkaike ? 2.0 : std::log(n);
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t p = 0; p < variance_by_order.size(); ++p) {
    const double value = n * std::log(std::max(variance_by_order[p], 1e-300)) + cost * static_cast<double>(p);
    if (value < least) {
      least = value;
      best = p;
    }
  }
  return best;
}

}  // namespace typodont::audio
