// A sine function that gives the same bits on every machine.
#pragma once

#include <cmath>

#include "engine/base/units.h"

namespace typodont::audio {

/// sin(2π t), any t ≥ 0.
inline float sine_of_turns(double t) noexcept {
  double u = t - std::floor(t) - 0.5;  // −½ … ½, and sin(2π t) = −sin(2π u)
  if (u > 0.25) u = 0.5 - u;
  if (u < -0.25) u = -0.5 - u;
  const double x = u * 2 * kPi, z = x * x;
  return static_cast<float>(-x * (1 + z * (-1.0 / 6 + z * (1.0 / 120 + z * (-1.0 / 5040 + z / 362880)))));
}

}  // namespace typodont::audio
