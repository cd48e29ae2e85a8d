#include "haptics/volume/leaf_front.h"

#include <algorithm>
#include <bit>

#include "engine/base/dispatch.h"
#include "engine/base/voxels.h"
#include "haptics/cutting/lanes.h"

namespace typodont::haptics {

namespace {

/// Writes to `found` the indices of all elements of `due` (path lengths) that are at most `path`. May read seven
/// elements beyond the end.
TYPODONT_DISPATCH("avx2", "default")
int find_due(const float* due, int count, float path, std::int32_t* found) {
  int n = 0;
  for (int i = 0; i < count; i += 8) {
    unsigned bits = bits_of(*reinterpret_cast<const F8*>(due + i) <= path);
    if (count - i < 8) bits &= (1u << (count - i)) - 1;
    for (; bits != 0; bits &= bits - 1) found[n++] = i + std::countr_zero(bits);
  }
  return n;
}

}  // namespace

void LeafFront::advance_to(const Sweep& sweep, const glm::ivec3& lo, const glm::ivec3& hi) {
  if (last_ && !last_->same_head(sweep)) forget();
  path_ = last_ ? path_ + sweep.path_from(*last_) : 0;
  if (path_ > kLongest) {
    const auto path = static_cast<float>(path_);
    for (float& due : due_) due -= path;
    for (Place& place : places_) {
      for (float& due : place.due) due -= path;
    }
    path_ = 0;
  }
  move_window(lo, hi);
  last_ = sweep;
}

void LeafFront::move_window(const glm::ivec3& lo, const glm::ivec3& hi) {
  const glm::ivec3 end = first_ + size_;
  const bool inside = glm::all(glm::lessThanEqual(first_, lo)) && glm::all(glm::lessThan(hi, end));
  if (last_ && inside) return;
  const glm::ivec3 first = lo - kBorder, size = hi - lo + 1 + 2 * kBorder;
  const std::size_t count = voxel_count(size);
  due_moved_.assign(count + kUnused, kNow);
  found_.resize(static_cast<std::size_t>(size.z));
  moved_.assign(count, {});
  if (last_) {
    const glm::ivec3 from = glm::max(first, first_), to = glm::min(first + size, end);
    for (int x = from.x; x < to.x; ++x) {
      for (int y = from.y; y < to.y && from.z < to.z; ++y) {
        const glm::ivec3 row(x, y, from.z);
        const auto old = static_cast<std::ptrdiff_t>(voxel_index(row - first_, size_)),
                   i = static_cast<std::ptrdiff_t>(voxel_index(row - first, size));
        std::copy_n(due_.begin() + old, to.z - from.z, due_moved_.begin() + i);
        std::copy_n(places_.begin() + old, to.z - from.z, moved_.begin() + i);
      }
    }
  }
  due_.swap(due_moved_);
  places_.swap(moved_);
  first_ = first, size_ = size;
}

std::span<const LeafFront::DuePlace> LeafFront::due(const glm::ivec3& lo, const glm::ivec3& hi) {
  due_places_.clear();
  const float now = path();
  for (int x = lo.x; x <= hi.x; ++x) {
    for (int y = lo.y; y <= hi.y; ++y) {
      const std::size_t row = voxel_index(glm::ivec3(x, y, lo.z) - first_, size_);
      const int count = find_due(due_.data() + row, hi.z - lo.z + 1, now, found_.data());
      for (int i = 0; i < count; ++i) {
        const int z = found_[static_cast<std::size_t>(i)];
        const std::size_t place = row + static_cast<std::size_t>(z);
        __builtin_prefetch(&places_[place], 1);
        due_places_.emplace_back(glm::ivec3(x, y, lo.z + z), &places_[place], &due_[place]);
      }
    }
  }
  return due_places_;
}

}  // namespace typodont::haptics
