// Volume of a cut, and times hardness where that differs by voxel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/contract/tissue.h"
#include "haptics/cutting/inside_fraction.h"
#include "haptics/dense_tissue.h"
#include "haptics/volume/label.h"

namespace typodont::haptics {

/// Same index in all three arrays.
struct GradedSamples {
  const float* distance = nullptr;
  const Tissue* tissue = nullptr;          // null: nothing filled
  const std::uint8_t* hardness = nullptr;  // null: no hardness per voxel

  /// Filled: the filling's.
  std::uint8_t felt(std::ptrdiff_t at) const noexcept {
    return tissue && is_filled(tissue[at]) ? kOwnHardness : hardness[at];
  }
};

/// Summed while cutting.
struct RemovedVolume {
  // voxels³, by the fraction inside
  PerTissue volume{};
  GradedSamples graded;  // input; without, `hardened` stays zero
  // 2⁻²³ voxel (inside_fraction.h) × byte (1 to 255): integers, so order does not matter.
  std::array<std::int64_t, kTissueCount> hardened{};

  /// Adds the removed volume `units` of one sample.
  void add(std::int64_t units, Tissue label, const float* sample) noexcept {
    const auto t = static_cast<std::size_t>(label);
    volume[t] += kFractionUnit * static_cast<double>(units);
    if (graded.hardness) hardened[t] += units * graded.felt(sample - graded.distance);
  }
};

}  // namespace typodont::haptics
