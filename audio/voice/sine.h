// Sine functions whose results are bit-identical on every processor.
#pragma once

#include <cmath>

#include "engine/base/units.h"

namespace typodont::audio {

/// Returns sin(2π t) for any t ≥ 0.
inline float sine_of_turns(double t) noexcept {
  double u = t - std::floor(t) - 0.5;  // −½ … ½, and sin(2π t) = −sin(2π u)
  if (u > 0.25) u = 0.5 - u;
  if (u < -0.25) u = -0.5 - u;
  const double x = u * 2 * kPi, z = x * x;
  return static_cast<float>(-x * (1 + z * (-1.0 / 6 + z * (1.0 / 120 + z * (-1.0 / 5040 + z / 362880)))));
}

/// Returns sin(π t) for −1 ≤ t ≤ 1, without branches.
inline float sine_of_half_turns(float t) noexcept {
  const float x = (0.5f - std::abs(std::abs(t) - 0.5f)) * static_cast<float>(kPi), z = x * x;
  const float positive = x * (1 + z * (-1.0f / 6 + z * (1.0f / 120 + z * (-1.0f / 5040 + z * (1.0f / 362880)))));
  return std::copysign(positive, t);
}

}  // namespace typodont::audio
