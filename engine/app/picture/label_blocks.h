// Tissue labels near the surface, in blocks of voxels. Each block stores the set of its tissues. It stores the labels
// of its voxels only after at() was called for one of them. Only for the thread that owns the tissue.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "engine/app/tissue/drawn_as.h"
#include "engine/base/voxels.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class LabelBlocks {
 public:
  explicit LabelBlocks(const DrawnAs& drawn_as = {}) : drawn_as_(drawn_as) {}
  /// Forgets all labels, because the volume may have changed.
  void forget();
  /// Selects the blocks around the voxels from `low` to `high` as the current blocks.
  void look_at(const haptics::TissueVolume& volume, const glm::ivec3& low, const glm::ivec3& high);
  /// Origin voxel of the coordinates that at() takes. In the current blocks, these coordinates are positive.
  const glm::ivec3& origin() const { return origin_; }
  /// Label of a voxel in the current blocks. `volume` must be the one passed to look_at().
  Tissue at(const haptics::TissueVolume& volume, const glm::ivec3& i) {
    const glm::ivec3 b(i.x >> kShift, i.y >> kShift, i.z >> kShift), in(i.x & kMask, i.y & kMask, i.z & kMask);
    Block& block = *around_[voxel_index(b, count_)];
    if (!block.labels) read(volume, block);
    return (*block.labels)[static_cast<std::size_t>(in.x << 2 * kShift | in.y << kShift | in.z)];
  }
  /// A set of tissues: bit t stands for tissue t.
  using Tissues = std::uint16_t;
  static_assert(kTissueCount <= 16);
  static constexpr Tissues set_of(Tissue tissue) { return static_cast<Tissues>(1u << static_cast<int>(tissue)); }
  /// True if the current blocks contain only one tissue besides air.
  bool one_tissue() const { return std::has_single_bit(all_ & ~unsigned{set_of(Tissue::kAir)}); }
  /// True if there may be other tissues than `expected` in or near the box (coordinates of at()). False: certainly
  /// none.
  bool may_contain_others(const glm::ivec3& low, const glm::ivec3& high, unsigned expected) const {
    return (tissues_in(low, high) & ~expected) != 0;
  }
  bool may_contain(const glm::ivec3& low, const glm::ivec3& high, Tissue tissue) const {
    return (tissues_in(low, high) & set_of(tissue)) != 0;
  }

 private:
  unsigned tissues_in(const glm::ivec3& low, const glm::ivec3& high) const {
    unsigned found = 0;
    for_each_voxel_between(low >> kCubeShift, high >> kCubeShift,
                           [&](const glm::ivec3& cube) { found |= cubes_[voxel_index(cube, 2 * count_)]; });
    return found;
  }

  static constexpr int kShift = 4, kSide = 1 << kShift, kMask = kSide - 1;
  static constexpr int kCubeShift = kShift - 1;  // a block consists of 2³ cubes of 8³ voxels
  using Labels = std::array<Tissue, kSide * kSide * kSide>;
  struct Block {
    glm::ivec3 key{0};
    std::array<Tissues, 8> cubes{};  // tissues of each cube; index 4x + 2y + z
    const Labels* labels = nullptr;  // null: not read yet
  };

  Block& block(const haptics::TissueVolume& volume, const glm::ivec3& key);
  /// Replaces each tissue by the tissue that pictures show in its place.
  Tissues drawn(Tissues tissues) const;
  /// Reads the labels of a block.
  void read(const haptics::TissueVolume& volume, Block& block);

  DrawnAs drawn_as_;
  std::unordered_map<std::uint64_t, Block> known_;
  /// The first `used_` elements are valid; others are spare memory.
  std::vector<std::unique_ptr<Labels>> labels_;
  std::size_t used_ = 0;
  std::vector<Block*> around_;
  std::vector<Tissues> cubes_;  // tissues of each cube in the current blocks
  Tissues all_ = 0;             // tissues in all current blocks
  glm::ivec3 origin_{0}, count_{0};
};

}  // namespace typodont
