#include <fmt/format.h>

#include <cmath>
#include <cstddef>

#include "engine/base/error.h"
#include "haptics/material_fit.h"

namespace typodont::haptics {

DampingFit fit_damping(std::span<const PushSample> samples) {
  // Determinant divided by (Σ depth² · Σ velocity²). If it is smaller, depth and velocity are proportional and cannot
  // be separated.
  constexpr double kIndependent = 1e-9;
  const auto each = [&](auto&& use) {
    for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
      const PushSample &before = samples[i - 1], &at = samples[i], &after = samples[i + 1];
      if (before.depth > 0 && at.depth > 0 && after.depth > 0 && at.force > 0)
        use(at.depth, (after.depth - before.depth) / (after.t - before.t), at.force);
    }
  };
  DampingFit fit;
  double dd = 0, dv = 0, vv = 0, df = 0, vf = 0;
  each([&](double d, double v, double f) {
    ++fit.samples;
    dd += d * d, dv += d * v, vv += v * v, df += d * f, vf += v * f;
  });
  if (fit.samples < 3)
    throw Error("curve", "", fmt::format("{} samples in contact", fit.samples), "3 or more in a row");
  const double det = dd * vv - dv * dv;
  if (!(det > kIndependent * dd * vv)) throw Error("curve", "", "one speed only", "a push at several speeds");
  fit.stiffness = (vv * df - dv * vf) / det;
  fit.damping = (dd * vf - dv * df) / det;
  double squares = 0;
  each([&](double d, double v, double f) {
    const double left = f - fit.stiffness * d - fit.damping * v;
    squares += left * left;
  });
  fit.rms = std::sqrt(squares / fit.samples);
  return fit;
}

}  // namespace typodont::haptics
