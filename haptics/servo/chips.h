// Chips of a bladed tool: their thickness, and the energy that they need.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"
#include "engine/contract/tissue.h"

namespace typodont::haptics {

struct ChipParameters {
  // s, of the thickness
  static constexpr double time = 0.03;
  // h / BladeLaw::chip; thinner and thicker chips were not measured
  static constexpr double min_range = 1e-2, max_range = 10;
};

/// h = v / (n N), m, of N blades at the angular speed `speed`, that advance by v.
inline double chip_thickness(double advance, double speed, int blades) noexcept {
  return 2 * kPi * advance / (speed * blades);
}

/// u / specific energy.
inline double energy_ratio(const BladeLaw& law, double chip) noexcept {
  if (law.exponent == 0) return law.energy_ratio;
  using P = ChipParameters;
  return law.energy_ratio * std::pow(std::clamp(chip / law.chip, P::min_range, P::max_range), -law.exponent);
}

}  // namespace typodont::haptics
