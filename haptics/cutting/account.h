// What a cut does to samples, and the volume that takes, by tissue. Private to haptics/cutting.
#pragma once

#include <cstdint>
#include <cstring>

#include "engine/contract/tissue.h"
#include "haptics/lanes.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

/// What every cut does, to eight samples: where `ahead` holds, a sample rises to its depth in the head if that is more than it
/// is and than what is kept true (`least`).
TYPODONT_KERNEL void raise_eight(const F8& old, const F8& depth, const I8& ahead, F8& least, I8& raised, F8& now) {
  least = old > -Sweep::kMargin ? old : F8{} - Sweep::kMargin;
  raised = ahead & (depth > least);
  now = raised ? depth : old;
}

/// What the share of each voxel inside the surface falls by, where distances rise.
TYPODONT_KERNEL void share_taken(const F8& was, const F8& is, F8& taken) {
  const F8 before = was > -0.5f ? was : F8{} - 0.5f, after = is < 0.5f ? is : F8{} + 0.5f;
  taken = after - before;
  taken = taken > 0.0f ? taken : F8{};
}

/// Volume taken, by label: a running sum as long as the label stays the same.
struct Account {
  PerTissue* removed;
  D4 low = {}, high = {};
  std::uint64_t label = 0;  // eight times

  /// Of eight samples, shares of voxels.
  TYPODONT_KERNEL void add(const F8& taken, const Tissue* labels) {
    std::uint64_t eight;
    std::memcpy(&eight, labels, sizeof eight);
    if (eight != label) {
      if (eight != (eight & 0xff) * 0x0101010101010101u) {
        for (int i = 0; i < 8; ++i) add(static_cast<double>(taken[i]), labels[i]);
        return;
      }
      close();
      label = eight;
    }
    low += __builtin_convertvector(__builtin_shufflevector(taken, taken, 0, 1, 2, 3), D4);
    high += __builtin_convertvector(__builtin_shufflevector(taken, taken, 4, 5, 6, 7), D4);
  }
  TYPODONT_KERNEL void add(double taken, Tissue tissue) { (*removed)[static_cast<std::size_t>(tissue)] += taken; }
  TYPODONT_KERNEL void close() {
    const D4 sum = low + high;
    (*removed)[label & 0xff] += (sum[0] + sum[1]) + (sum[2] + sum[3]);
    low = high = D4{};
  }
};

}  // namespace typodont::haptics
