#include "engine/app/picture/label_blocks.h"

#include <algorithm>

namespace typodont {

void LabelBlocks::forget() {
  known_.clear();
  used_ = 0;
}

const LabelBlocks::Block& LabelBlocks::block(const haptics::TissueVolume& volume, const glm::ivec3& key) {
  const auto part = [](int v) { return static_cast<std::uint64_t>(v + (1 << 20)) & 0x1fffff; };
  const Block*& found = known_[part(key.x) << 42 | part(key.y) << 21 | part(key.z)];
  if (found) return *found;
  if (used_ == blocks_.size()) blocks_.push_back(std::make_unique_for_overwrite<Block>());
  Block& fresh = *blocks_[used_++];
  volume.copy(kSide * key, glm::ivec3(kSide), nullptr, fresh.labels.data());
  drawn_as_.apply(fresh.labels);
  std::uint8_t some = 0;
  for (const Tissue t : fresh.labels) some = std::max(some, static_cast<std::uint8_t>(t));
  fresh.only = static_cast<Tissue>(some);
  fresh.empty = fresh.only == Tissue::kAir;
  std::uint8_t differs = 0;
  for (const Tissue t : fresh.labels)
    differs = static_cast<std::uint8_t>(differs | ((t != fresh.only) & (t != Tissue::kAir)));
  if (differs) fresh.only = Tissue::kAir;
  found = &fresh;
  return fresh;
}

void LabelBlocks::look_at(const haptics::TissueVolume& volume, const glm::ivec3& low, const glm::ivec3& high) {
  const glm::ivec3 first(low.x >> kShift, low.y >> kShift, low.z >> kShift),
      last(high.x >> kShift, high.y >> kShift, high.z >> kShift);
  origin_ = kSide * first;
  count_ = last - first + 1;
  around_.clear();
  only_ = Tissue::kAir;
  bool several = false;
  glm::ivec3 key;
  for (key.x = first.x; key.x <= last.x; ++key.x)
    for (key.y = first.y; key.y <= last.y; ++key.y)
      for (key.z = first.z; key.z <= last.z; ++key.z) {
        const Block& b = block(volume, key);
        around_.push_back(&b.labels);
        if (b.empty) continue;
        several = several || b.only == Tissue::kAir || (only_ != Tissue::kAir && b.only != only_);
        only_ = b.only;
      }
  if (several) only_ = Tissue::kAir;
}

}  // namespace typodont
