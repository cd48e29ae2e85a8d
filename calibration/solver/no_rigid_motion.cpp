#include "calibration/solver/no_rigid_motion.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "calibration/solver/eigen_math.h"
#include "calibration/statistics.h"

namespace typodont::calibration {

bool mirrored(Points p_H, Points p_D, const Fit& fit, double rounding) {
  const double dof = 3 * static_cast<double>(fit.pairs.size()) - 6;
  if (dof < 6) return false;
  std::vector<dvec3> h, inverted;
  for (const std::size_t i : fit.pairs) h.push_back(p_H[i]), inverted.push_back(-p_D[i]);
  const Pose X = fit_rigid(h, inverted);
  double sse = dof * rounding * rounding;
  for (std::size_t i = 0; i < h.size(); ++i) {
    const dvec3 r = X * h[i] - inverted[i];
    sse += glm::dot(r, r);
  }
  return fit.sse > sse && fit.sse > sse * f_quantile(0.99, dof, dof);
}

std::optional<double> other_scale(Points p_H, Points p_D, const Fit& fit, double rounding) {
  const double dof = 3 * static_cast<double>(fit.pairs.size()) - 7;
  if (dof < 2) return std::nullopt;
  dvec3 c_H(0), c_D(0);
  for (const std::size_t i : fit.pairs) c_H += p_H[i], c_D += p_D[i];
  c_H /= static_cast<double>(fit.pairs.size()), c_D /= static_cast<double>(fit.pairs.size());
  // The best rotation is independent of scale (Umeyama 1991).
  double hh = 0, hd = 0;
  for (const std::size_t i : fit.pairs) {
    const dvec3 h = p_H[i] - c_H;
    hh += glm::dot(h, h), hd += glm::dot(fit.X_DH.rotate(h), p_D[i] - c_D);
  }
  if (!(hh > 0)) return std::nullopt;
  const double scale = hd / hh, gained = (scale - 1) * (scale - 1) * hh;
  const double sse = std::max(fit.sse - gained, dof * rounding * rounding);
  if (std::abs(scale - 1) < 0.02 || gained < sse / dof * f_quantile(1 - 1e-4, 1, dof)) return std::nullopt;
  return scale;
}

std::optional<double> other_scale_by_median(Points p_H, Points p_D, double rounding) {
  const std::size_t n = p_H.size(),
                    // 64 points give two thousand distances, which are enough.
      step = std::max<std::size_t>(1, n / 64);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < n; i += step) {
    for (std::size_t j = i + step; j < n; j += step) {
      const double h = glm::length(p_H[i] - p_H[j]), d = glm::length(p_D[i] - p_D[j]);
      if (h > 10 * rounding && d > 10 * rounding) ratios.push_back(d / h);
    }
  }
  if (ratios.empty()) return std::nullopt;
  const double scale = median(std::move(ratios));
  std::vector<dvec3> rescaled(p_H.begin(), p_H.end());
  for (dvec3& p : rescaled) p *= scale;
  Indices everyone(n);
  std::iota(everyone.begin(), everyone.end(), 0u);
  const Fit straight = fit_to(p_H, p_D, everyone), scaled = fit_to(rescaled, p_D, everyone);
  if (std::abs(std::log(scale)) > 0.1 && scaled.sse < 0.01 * straight.sse) return scale;
  return std::nullopt;
}

// Fits the reflected points: p_D -> -p_D.
bool mirror_fits_better(Points p_H, Points p_D, const Fit& fit, const RegistrationOptions& options) {
  if (p_H.size() < 4) return false;
  std::vector<dvec3> inverted(p_D.size());
  std::transform(p_D.begin(), p_D.end(), inverted.begin(), [](const dvec3& p) { return -p; });
  const Fit mirrored = max_agreement(p_H, inverted, options, 5 * fit.pairs.size() / 4).fit;
  if (mirrored.pairs.size() < std::max<std::size_t>(4, p_H.size() / 4)) return false;
  // A flat set is its own mirror image. For other sets, smaller residuals or more pairs decide.
  const double floor2 = std::pow(rounding_of(p_H, p_D), 2);
  const auto variance = [&](const Fit& f) {
    return std::max(f.sse / std::max(1.0, 3 * static_cast<double>(f.pairs.size()) - 6), floor2);
  };
  const double ratio = variance(mirrored) / variance(fit);
  return (ratio < 4 && 4 * mirrored.pairs.size() > 5 * fit.pairs.size()) ||
         (ratio < 0.1 && mirrored.pairs.size() >= fit.pairs.size());
}

}  // namespace typodont::calibration
