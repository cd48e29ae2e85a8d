#include <algorithm>
#include <cmath>

#include "engine/base/voxels.h"
#include "haptics/tissue_volume.h"
#include "haptics/volume/leaf_key.h"

namespace typodont::haptics {

namespace {

constexpr std::int32_t kEmpty = -1, kFull = -2;

}  // namespace

NaturalSurface::NaturalSurface(const TissueVolume& volume) : frame_(volume.frame()) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  if (lo.x > hi.x) return;
  first_ = leaf_key(lo);
  count_ = leaf_key(hi) - first_ + 1;
  block_.reserve(voxel_count(count_));
  for_each_voxel(count_, [&](const glm::ivec3& key) {
    SolidBits bits;
    volume.solid_block(first_ + key, bits);
    const auto all = [&](std::uint64_t word) {
      return std::all_of(bits.begin(), bits.end(), [&](std::uint64_t w) { return w == word; });
    };
    const auto next = static_cast<std::int32_t>(mixed_.size());
    block_.push_back(all(0) ? kEmpty : all(~std::uint64_t{0}) ? kFull : next);
    if (block_.back() == next) mixed_.push_back(bits);
  });
}

bool NaturalSurface::solid(const glm::ivec3& voxel) const {
  const glm::ivec3 block = leaf_key(voxel) - first_, in = voxel & 7;
  if (!in_grid(block, count_)) return false;
  const std::int32_t found = block_[voxel_index(block, count_)];
  if (found < 0) return found == kFull;
  return mixed_[static_cast<std::size_t>(found)][static_cast<std::size_t>(in.x)] >> (8 * in.y + in.z) & 1;
}

double NaturalSurface::inside(const glm::dvec3& p_W) const {
  const glm::dvec3 at = frame_.to_voxels(p_W);
  glm::ivec3 voxel(at);  // rounds towards zero, which is wrong for negative numbers, so the next line corrects it
  for (int a = 0; a < 3; ++a) voxel[a] -= at[a] < voxel[a];
  const glm::ivec3 in = voxel & 7;
  if (in.x < 7 && in.y < 7 && in.z < 7) {
    // All eight voxels around the point lie in one block, which usually is completely solid or empty.
    const glm::ivec3 block = leaf_key(voxel) - first_;
    if (!in_grid(block, count_)) return 0;
    const std::int32_t found = block_[voxel_index(block, count_)];
    if (found < 0) return found == kFull ? 1 : 0;
  }
  const glm::dvec3 low(voxel), part = at - low;
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 step(corner & 1, corner >> 1 & 1, corner >> 2);
    if (!solid(voxel + step)) continue;
    const glm::dvec3 weight = glm::mix(1.0 - part, part, glm::dvec3(step));
    sum += weight.x * weight.y * weight.z;
  }
  return sum;
}

}  // namespace typodont::haptics
