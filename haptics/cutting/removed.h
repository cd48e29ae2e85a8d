// Volume that a cut removes, and this volume × hardness if hardness differs per voxel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/contract/tissue.h"
#include "haptics/cutting/inside_fraction.h"
#include "haptics/dense_tissue.h"
#include "haptics/volume/label.h"

namespace typodont::haptics {

/// Distances, labels and hardness of samples; the same index refers to the same sample in all three arrays.
struct GradedSamples {
  const float* distance = nullptr;
  const Tissue* tissue = nullptr;          // tissue labels; null: no sample is filled
  const std::uint8_t* hardness = nullptr;  // null: the tissue has no hardness per voxel

  /// Hardness of a sample; filling has its own hardness.
  std::uint8_t felt(std::ptrdiff_t at) const noexcept {
    return tissue && is_filled(tissue[at]) ? kOwnHardness : hardness[at];
  }
};

/// Removed volume, summed while cutting.
struct RemovedVolume {
  // voxels³, sum of the removed fractions of all voxels
  PerTissue volume{};
  GradedSamples graded;  // input: hardness of the samples; without it, `hardened` remains zero
  // Units of 2⁻²³ voxel (inside_fraction.h) × hardness byte (1 to 255). Integers, so the order of the sum does not
  // matter.
  std::array<std::int64_t, kTissueCount> hardened{};

  /// Adds the volume that was removed at one sample. `units`: volume in units of 2⁻²³ voxel.
  void add(std::int64_t units, Tissue label, const float* sample) noexcept {
    const auto t = static_cast<std::size_t>(label);
    volume[t] += kFractionUnit * static_cast<double>(units);
    if (graded.hardness) hardened[t] += units * graded.felt(sample - graded.distance);
  }
};

}  // namespace typodont::haptics
