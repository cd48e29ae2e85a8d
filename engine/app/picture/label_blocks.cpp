#include "engine/app/picture/label_blocks.h"

#include "engine/app/tissue/brick_update.h"

namespace typodont {

void LabelBlocks::forget() {
  known_.clear();
  used_ = 0;
}

void LabelBlocks::read(const haptics::TissueVolume& volume, Block& block) {
  if (used_ == labels_.size()) labels_.push_back(std::make_unique_for_overwrite<Labels>());
  Labels& labels = *labels_[used_++];
  volume.copy(kSide * block.key, glm::ivec3(kSide), nullptr, labels.data());
  drawn_as_.apply(labels);
  block.labels = &labels;
}

LabelBlocks::Tissues LabelBlocks::drawn(Tissues tissues) const {
  unsigned looks = 0;
  for (int t = 0; t < kTissueCount; ++t) {
    if (tissues >> t & 1) looks |= set_of(drawn_as_(static_cast<Tissue>(t)));
  }
  return static_cast<Tissues>(looks);
}

LabelBlocks::Block& LabelBlocks::block(const haptics::TissueVolume& volume, const glm::ivec3& key) {
  const auto [found, unknown] = known_.try_emplace(brick_number(key));
  Block& block = found->second;
  if (!unknown) return block;
  block.key = key;
  for (int cube = 0; cube < 8; ++cube) {
    const glm::ivec3 at = 2 * key + glm::ivec3(cube >> 2, cube >> 1 & 1, cube & 1);
    block.cubes[static_cast<std::size_t>(cube)] = drawn(static_cast<Tissues>(volume.tissues_in_block(at)));
  }
  return block;
}

void LabelBlocks::look_at(const haptics::TissueVolume& volume, const glm::ivec3& low, const glm::ivec3& high) {
  const glm::ivec3 first(low.x >> kShift, low.y >> kShift, low.z >> kShift),
      last(high.x >> kShift, high.y >> kShift, high.z >> kShift);
  origin_ = kSide * first;
  count_ = last - first + 1;
  around_.clear();
  cubes_.resize(voxel_count(2 * count_));
  unsigned all = 0;
  for_each_voxel_between(first, last, [&](const glm::ivec3& key) {
    Block& b = block(volume, key);
    around_.push_back(&b);
    for (int cube = 0; cube < 8; ++cube) {
      const Tissues tissues = b.cubes[static_cast<std::size_t>(cube)];
      const glm::ivec3 at = 2 * (key - first) + glm::ivec3(cube >> 2, cube >> 1 & 1, cube & 1);
      cubes_[voxel_index(at, 2 * count_)] = tissues;
      all |= tissues;
    }
  });
  all_ = static_cast<Tissues>(all);
}

}  // namespace typodont
