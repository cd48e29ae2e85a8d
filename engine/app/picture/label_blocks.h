// Tissue labels near the surface, in blocks. Each block is read from the volume only once, and stores whether it
// contains more than one tissue. For the thread that owns the tissue.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "engine/app/tissue/drawn_as.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class LabelBlocks {
 public:
  explicit LabelBlocks(const DrawnAs& drawn_as = {}) : drawn_as_(drawn_as) {}
  /// Discards all blocks of labels, because the volume may have changed.
  void forget();
  /// Loads the blocks of labels that contain the voxels from `low` to `high`.
  void look_at(const haptics::TissueVolume& volume, const glm::ivec3& low, const glm::ivec3& high);
  /// Returns the origin (voxels) of the coordinates that at() expects. Within the loaded blocks, these coordinates are
  /// positive.
  const glm::ivec3& origin() const { return origin_; }
  Tissue at(const glm::ivec3& i) const {
    const glm::ivec3 b(i.x >> kShift, i.y >> kShift, i.z >> kShift), in(i.x & kMask, i.y & kMask, i.z & kMask);
    return (*around_[static_cast<std::size_t>((b.x * count_.y + b.y) * count_.z + b.z)])[static_cast<std::size_t>(
        in.x << 2 * kShift | in.y << kShift | in.z)];
  }
  /// If the loaded blocks contain only one tissue besides air, returns this tissue; otherwise returns air.
  Tissue only() const { return only_; }

 private:
  static constexpr int kShift = 4, kSide = 1 << kShift, kMask = kSide - 1;
  using Labels = std::array<Tissue, kSide * kSide * kSide>;
  struct Block {
    Labels labels;
    Tissue only;  // If the voxels of this block contain only one tissue besides air, this tissue; otherwise air.
    bool empty;   // true: the block contains only air
  };

  const Block& block(const haptics::TissueVolume& volume, const glm::ivec3& key);

  DrawnAs drawn_as_;
  /// blocks of labels; only the first `used_` are valid, the others are unused memory for later blocks
  std::vector<std::unique_ptr<Block>> blocks_;
  std::size_t used_ = 0;
  std::unordered_map<std::uint64_t, const Block*> known_;
  std::vector<const Labels*> around_;
  glm::ivec3 origin_{0}, count_{0};
  Tissue only_ = Tissue::kAir;
};

}  // namespace typodont
