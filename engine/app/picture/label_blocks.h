// Tissue labels around pieces of surface, read from the carver's volume once however many pieces look at them: in
// blocks that know whether more than one tissue is in them. Carver's thread.
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
  /// The volume may have changed since.
  void forget();
  /// Looks at [low, high], voxels.
  void look_at(const haptics::TissueVolume& volume, const glm::ivec3& low, const glm::ivec3& high);
  /// Places given to at() are relative to it: positive within what is looked at.
  const glm::ivec3& origin() const { return origin_; }
  Tissue at(const glm::ivec3& i) const {
    const glm::ivec3 b(i.x >> kShift, i.y >> kShift, i.z >> kShift), in(i.x & kMask, i.y & kMask, i.z & kMask);
    return (*around_[static_cast<std::size_t>((b.x * count_.y + b.y) * count_.z + b.z)])[static_cast<std::size_t>(
        in.x << 2 * kShift | in.y << kShift | in.z)];
  }
  /// The one tissue besides air in all blocks looked at; air where there are several, or none.
  Tissue only() const { return only_; }

 private:
  static constexpr int kShift = 4, kSide = 1 << kShift, kMask = kSide - 1;
  using Labels = std::array<Tissue, kSide * kSide * kSide>;
  struct Block {
    Labels labels;
    Tissue only;  // as only(), of this block
    bool empty;   // nothing but air
  };

  const Block& block(const haptics::TissueVolume& volume, const glm::ivec3& key);

  DrawnAs drawn_as_;
  std::vector<std::unique_ptr<Block>> blocks_;  // the first `used_` are of now
  std::size_t used_ = 0;
  std::unordered_map<std::uint64_t, const Block*> known_;
  std::vector<const Labels*> around_;
  glm::ivec3 origin_{0}, count_{0};
  Tissue only_ = Tissue::kAir;
};

}  // namespace typodont
