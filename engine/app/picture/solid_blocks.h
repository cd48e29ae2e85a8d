// Tells which samples of a volume are in tissue. Reads blocks of 8³ samples once, when they are needed. Only for the
// thread that owns the tissue.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>

#include "engine/app/tissue/brick_update.h"
#include "engine/base/vectors.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class SolidBlocks {
 public:
  /// Indices of four voxels, one in each lane.
  struct Voxels {
    FourInts x, y, z;
  };

  /// Forgets all blocks, because the volume may have changed.
  void forget() {
    blocks_.clear();
    recent_.fill({});
  }
  /// Bit i of the result: voxel i is in tissue. Only the first `count` voxels are tested. `volume` must be the same
  /// until forget().
  unsigned solid(const haptics::TissueVolume& volume, const Voxels& voxels, int count) {
    const FourInts x = voxels.x >> 3, y = voxels.y >> 3, z = voxels.z >> 3;  // the blocks of the voxels
    const FourInts place = (x & kLow) << 2 * kLowBits | (y & kLow) << kLowBits | (z & kLow);
    const FourInts tag = high_bits(x) << 2 * kHighBits | high_bits(y) << kHighBits | high_bits(z);
    const FourInts row = voxels.x & 7, bit = (voxels.y & 7) << 3 | (voxels.z & 7);
    unsigned mask = 0;
    for (int i = 0; i < count; ++i) {
      Recent& recent = recent_[static_cast<std::size_t>(place[i])];
      if (!recent.bits || recent.tag != tag[i]) recent = {tag[i], &block(volume, {x[i], y[i], z[i]})};
      mask |= static_cast<unsigned>((*recent.bits)[static_cast<std::size_t>(row[i])] >> bit[i] & 1) << i;
    }
    return mask;
  }

 private:
  // The low bits of a block's index select its place in `recent_`. A brick's samples are in at most 8³ blocks, so each
  // has its own place. The next bits tell which block is there; no axis has more than 2^13 blocks.
  static constexpr int kLowBits = 3, kLow = (1 << kLowBits) - 1, kHighBits = 10;
  static FourInts high_bits(const FourInts& key) { return key >> kLowBits & ((1 << kHighBits) - 1); }
  struct Recent {
    int tag = 0;
    const haptics::SolidBits* bits = nullptr;
  };

  const haptics::SolidBits& block(const haptics::TissueVolume& volume, const glm::ivec3& key) {
    const auto [found, fresh] = blocks_.try_emplace(brick_number(key));
    if (fresh) volume.solid_block(key, found->second);
    return found->second;
  }

  std::unordered_map<std::uint64_t, haptics::SolidBits> blocks_;
  std::array<Recent, 1 << 3 * kLowBits> recent_{};  // cache: the last block read, for each combination of low bits
};

}  // namespace typodont
