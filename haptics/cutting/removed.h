// The volume that a cut removes, and the sum of this volume times hardness for tissue whose hardness differs from
// voxel to voxel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/contract/tissue.h"
#include "haptics/hardness.h"
#include "haptics/inside_fraction.h"
#include "haptics/label.h"

namespace typodont::haptics {

/// Samples of a patch (copied tissue) with hardness per voxel; a sample has the same index in all three arrays.
struct GradedSamples {
  const float* distance = nullptr;
  const Tissue* tissue = nullptr;          // labels of the samples; null: no sample is filled
  const std::uint8_t* hardness = nullptr;  // null if the tissue has no hardness per voxel

  /// Returns the hardness byte of a sample. If a filling covers the sample, returns the hardness byte of the filling.
  std::uint8_t felt(std::ptrdiff_t at) const noexcept {
    return tissue && is_filled(tissue[at]) ? kOwnHardness : hardness[at];
  }
};

/// The volume that a cut removed, summed by the kernels while they cut.
struct RemovedVolume {
  // voxels³, sum over the voxels of the fraction inside the surface before the cut minus the fraction after it
  PerTissue volume{};
  GradedSamples graded;  // input: the samples with hardness; without hardness, `hardened` stays zero
  // Removed volume times hardness. The unit of the volume is 2⁻²³ voxel (inside_fraction.h), and the hardness is a byte
  // (1 to 255). The sums are integers, so they do not depend on the order of the samples.
  std::array<std::int64_t, kTissueCount> hardened{};

  /// Adds the removed volume `units` of one sample.
  void add(std::int64_t units, Tissue label, const float* sample) noexcept {
    const auto t = static_cast<std::size_t>(label);
    volume[t] += kFractionUnit * static_cast<double>(units);
    if (graded.hardness) hardened[t] += units * graded.felt(sample - graded.distance);
  }
};

}  // namespace typodont::haptics
