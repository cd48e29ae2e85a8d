#include "haptics/volume/leaf_front.h"

#include <algorithm>

namespace typodont::haptics {

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
  const glm::ivec3 first = lo - kRoom, size = hi - lo + 1 + 2 * kRoom;
  const auto count = static_cast<std::size_t>(size.x) * size.y * size.z;
  due_moved_.assign(count, kNow);
  moved_.assign(count, {});
  if (last_) {
    const glm::ivec3 from = glm::max(first, first_), to = glm::min(first + size, end);
    for (int x = from.x; x < to.x; ++x) {
      for (int y = from.y; y < to.y && from.z < to.z; ++y) {
        const Row old = row({x, y, from.z});
        const glm::ivec3 at = glm::ivec3(x, y, from.z) - first;
        const std::ptrdiff_t i = (at.x * size.y + at.y) * size.z + at.z;
        std::copy_n(old.due, to.z - from.z, due_moved_.begin() + i);
        std::copy_n(old.places, to.z - from.z, moved_.begin() + i);
      }
    }
  }
  due_.swap(due_moved_);
  places_.swap(moved_);
  first_ = first, size_ = size;
}

}  // namespace typodont::haptics
