// Stores which samples of the volume now lie in tissue, in blocks. Each block is read only once, when it is needed. For
// the thread that owns the tissue.
#pragma once

#include <cstdint>
#include <unordered_map>

#include "engine/app/field/brick_update.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class SolidBlocks {
 public:
  /// Discards all blocks, because the volume may have changed.
  void forget() {
    blocks_.clear();
    last_ = nullptr;
  }
  /// Returns true if the sample lies in tissue. All calls after forget() must have the same `volume`.
  bool solid(const haptics::TissueVolume& volume, const glm::ivec3& voxel) {
    const glm::ivec3 key = voxel >> 3, in = voxel & 7;
    if (!last_ || key != last_key_) {
      const auto [found, fresh] = blocks_.try_emplace(brick_number(key));
      if (fresh) volume.solid_block(key, found->second);
      last_ = &found->second;
      last_key_ = key;
    }
    return (*last_)[static_cast<std::size_t>(in.x)] >> (8 * in.y + in.z) & 1;
  }

 private:
  std::unordered_map<std::uint64_t, haptics::SolidBits> blocks_;
  const haptics::SolidBits* last_ = nullptr;  // the block that the last call used
  glm::ivec3 last_key_{0};
};

}  // namespace typodont
