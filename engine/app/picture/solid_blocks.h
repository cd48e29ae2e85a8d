// Stores which samples of the volume now lie in tissue, in blocks of 8³ samples. Each block is read only once, when it
// is needed. For the thread that owns the tissue.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>

#include "engine/app/field/brick_update.h"
#include "engine/base/vectors.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class SolidBlocks {
 public:
  /// Indices of a voxel in a vector register: x, y, z, and a fourth lane without meaning.
  using Voxel = FourInts;

  /// Discards all blocks, because the volume may have changed.
  void forget() {
    blocks_.clear();
    recent_.fill({});
  }
  /// Returns true if the sample lies in tissue. All calls after forget() must have the same `volume`.
  bool solid(const haptics::TissueVolume& volume, const Voxel& voxel) {
    const Voxel key = voxel >> 3, in = voxel & 7, place = key & (kWindow - 1);
    Recent& recent = recent_[static_cast<std::size_t>((place[0] * kWindow + place[1]) * kWindow + place[2])];
    const Voxel differs = recent.key != key;
    if (!recent.bits || (differs[0] | differs[1] | differs[2]) != 0) {
      const glm::ivec3 block(key[0], key[1], key[2]);
      const auto [found, fresh] = blocks_.try_emplace(brick_number(block));
      if (fresh) volume.solid_block(block, found->second);
      recent = {key, &found->second};
    }
    return (*recent.bits)[static_cast<std::size_t>(in[0])] >> (8 * in[1] + in[2]) & 1;
  }

 private:
  // Blocks along each axis. The samples around one brick (mesh block) lie in fewer blocks, so that each of these blocks
  // has its own place in `recent_`.
  static constexpr int kWindow = 8;
  struct Recent {
    Voxel key = {};
    const haptics::SolidBits* bits = nullptr;
  };

  std::unordered_map<std::uint64_t, haptics::SolidBits> blocks_;
  std::array<Recent, kWindow * kWindow * kWindow> recent_{};  // the last block that was used at each place
};

}  // namespace typodont
