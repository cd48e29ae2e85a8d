// Chips of blades and of a diamond bur's grains: their thickness, the energy to cut them, and the space for them.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"
#include "engine/contract/tissue.h"
#include "haptics/tool.h"

namespace typodont::haptics {

struct ChipParameters {
  // s, time constant of the filter for the feed per turn
  static constexpr double time = 0.03;
  // Range of (chip thickness / EdgeLaw::chip) for which the energy was measured.
  static constexpr double min_range = 0.04, max_range = 10;
  // distance between neighbouring grains divided by the size of a grain: grains cover a quarter of the surface
  static constexpr double grain_distance = 2;
  // width of a grain's chip divided by the thickness of the chip
  static constexpr double chip_width = 10;
  // chip_space: value of (feed per turn / grain size) at which chips fill the space between the grains. max_full:
  // largest feed divided by the feed at which this space is full; a faster feed occurs only in air.
  static constexpr double chip_space = 3.1e-3, max_full = 1.2;
};

/// Chip thickness, m; `feed`: m per turn. Bur with N blades: feed / N. Diamond bur of radius r: a √(feed / (2π r b)),
/// a: distance between neighbouring grains; b = chip_width.
inline double chip_thickness(const Tool& tool, double feed) noexcept {
  using P = ChipParameters;
  if (tool.blades > 0) return feed / tool.blades;
  return P::grain_distance * tool.grit * std::sqrt(std::max(feed, 0.0) / (2 * kPi * tool.radius() * P::chip_width));
}

/// Energy per removed volume divided by the specific energy of the material.
inline double energy_ratio(const EdgeLaw& law, double chip) noexcept {
  if (law.exponent == 0) return law.energy_ratio;
  using P = ChipParameters;
  return law.energy_ratio * std::pow(std::clamp(chip / law.chip, P::min_range, P::max_range), -law.exponent);
}

/// Total work divided by work of cutting. Above 1 if chips rub because the space between grains is small; blades: 1.
inline double rubbing(const Tool& tool, double feed) noexcept {
  using P = ChipParameters;
  if (!(tool.grit > 0 && feed > 0)) return 1;
  const double full = std::min(feed / (P::chip_space * tool.grit), P::max_full), full2 = full * full,
               full4 = full2 * full2;
  return 1 + full4 * full4;
}

}  // namespace typodont::haptics
