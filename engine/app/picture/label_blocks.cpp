#include "engine/app/picture/label_blocks.h"

#include <cstring>

#include "engine/app/field/brick_update.h"

namespace typodont {

void LabelBlocks::forget() {
  known_.clear();
  used_ = 0;
}

void LabelBlocks::copy(const haptics::TissueVolume& volume, const glm::ivec3& key, Labels& labels) const {
  volume.copy(kSide * key, glm::ivec3(kSide), nullptr, labels.data());
  drawn_as_.apply(labels);
}

void LabelBlocks::read(const haptics::TissueVolume& volume, Block& block) {
  if (used_ == labels_.size()) labels_.push_back(std::make_unique_for_overwrite<Labels>());
  Labels& labels = *labels_[used_++];
  copy(volume, block.key, labels);
  block.labels = &labels;
}

LabelBlocks::Block& LabelBlocks::block(const haptics::TissueVolume& volume, const glm::ivec3& key) {
  const auto [found, unknown] = known_.try_emplace(brick_number(key));
  Block& block = found->second;
  if (!unknown) return block;
  block.key = key;
  copy(volume, key, scratch_);
  for (int cube = 0; cube < 8; ++cube) {
    const Tissue* first = &scratch_[static_cast<std::size_t>(
        kCube * ((cube >> 2) * kSide * kSide + (cube >> 1 & 1) * kSide + (cube & 1)))];
    unsigned tissues = 0;
    std::uint64_t last = ~std::uint64_t{0};  // no row of labels is equal to this
    for (int row = 0; row < kCube * kCube; ++row) {
      const Tissue* labels = first + (row / kCube) * kSide * kSide + row % kCube * kSide;
      std::uint64_t eight;  // usually a row of eight labels is equal to the row before
      static_assert(sizeof eight == kCube * sizeof(Tissue));
      std::memcpy(&eight, labels, sizeof eight);
      if (eight == last) continue;
      last = eight;
      const bool uniform = eight == (eight & 0xff) * 0x0101010101010101u;
      for (int z = 0; z < (uniform ? 1 : kCube); ++z) tissues |= set_of(labels[z]);
    }
    block.cubes[static_cast<std::size_t>(cube)] = static_cast<Tissues>(tissues);
  }
  return block;
}

void LabelBlocks::look_at(const haptics::TissueVolume& volume, const glm::ivec3& low, const glm::ivec3& high) {
  const glm::ivec3 first(low.x >> kShift, low.y >> kShift, low.z >> kShift),
      last(high.x >> kShift, high.y >> kShift, high.z >> kShift);
  origin_ = kSide * first;
  count_ = last - first + 1;
  around_.clear();
  cubes_.resize(8 * static_cast<std::size_t>(count_.x) * static_cast<std::size_t>(count_.y) *
                static_cast<std::size_t>(count_.z));
  unsigned all = 0;
  glm::ivec3 key;
  for (key.x = first.x; key.x <= last.x; ++key.x)
    for (key.y = first.y; key.y <= last.y; ++key.y)
      for (key.z = first.z; key.z <= last.z; ++key.z) {
        Block& b = block(volume, key);
        around_.push_back(&b);
        for (int cube = 0; cube < 8; ++cube) {
          const Tissues tissues = b.cubes[static_cast<std::size_t>(cube)];
          const glm::ivec3 at = 2 * (key - first) + glm::ivec3(cube >> 2, cube >> 1 & 1, cube & 1);
          cubes_[static_cast<std::size_t>((at.x * 2 * count_.y + at.y) * 2 * count_.z + at.z)] = tissues;
          all |= tissues;
        }
      }
  all_ = static_cast<Tissues>(all);
}

}  // namespace typodont
