// The volume that a cut removes, and what it costs in tissue whose hardness differs from voxel to voxel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/contract/tissue.h"
#include "haptics/hardness.h"
#include "haptics/label.h"
#include "haptics/share.h"

namespace typodont::haptics {

/// Samples of a graded patch, with the same index in all three arrays.
struct GradedSamples {
  const float* distance = nullptr;
  const Tissue* tissue = nullptr;          // null: no sample is filled
  const std::uint8_t* hardness = nullptr;  // null: the tissue is not graded

  /// Hardness byte of a sample, or that of the filling that covers it.
  std::uint8_t felt(std::ptrdiff_t at) const noexcept {
    return tissue && is_filled(tissue[at]) ? kOwnHardness : hardness[at];
  }
};

/// What a cut removed, summed by the kernels while they cut.
struct RemovedVolume {
  PerTissue volume{};    // voxels³; the fraction of each voxel inside the surface, before minus after
  GradedSamples graded;  // input: where the hardness is; without hardness `hardened` stays zero
  // Units of share.h times hardness bytes. Integers, so the sum does not depend on the order of the samples.
  std::array<std::int64_t, kTissueCount> hardened{};

  /// Adds `units` of volume of one sample.
  void add(std::int64_t units, Tissue label, const float* sample) noexcept {
    const auto t = static_cast<std::size_t>(label);
    volume[t] += kFractionUnit * static_cast<double>(units);
    if (graded.hardness) hardened[t] += units * graded.felt(sample - graded.distance);
  }
};

}  // namespace typodont::haptics
