#include "haptics/cutting/cut_front.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "engine/base/voxels.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

namespace {

// margin of the box of blocks around the head, in blocks, so that the box moves seldom
constexpr int kBorder = 2;
// largest number of groups in all lists of a CutFront; dental burs need fewer
constexpr std::size_t kGroups = 1 << 15;

glm::ivec3 blocks(const glm::ivec3& voxel, int rows, int deep) {
  const auto down = [](int v, int step) { return (v - (v % step + step) % step) / step; };
  return {down(voxel.x, rows), down(voxel.y, rows), down(voxel.z, deep)};
}

}  // namespace

CutFront::CutFront(std::span<const Tool> tools, double voxel, int lanes) : lanes_(std::min(lanes, widest_group())) {
  double reach = 0;
  for (const Tool& tool : tools) reach = std::max(reach, tool.reach() / voxel);
  const double edge = 2 * (reach + static_cast<double>(Sweep::kMargin) + 4);
  const int across = static_cast<int>(std::ceil(edge / kRows)) + 1 + 2 * kBorder;
  size_ = {across, across, static_cast<int>(std::ceil(edge / kRowLength)) + 1 + 2 * kBorder};
  const std::size_t count = voxel_count(size_);
  due_.assign(count + 8, 0);
  moved_ = due_;
  heights_.assign(static_cast<std::size_t>(3 * (size_.z * kRowLength + kBeyond)), 0);
  const int layers = across - 2 * kBorder;
  parts_.resize(static_cast<std::size_t>(
      std::clamp(static_cast<int>(std::bit_floor(static_cast<unsigned>(layers))), 4, kMaxParts)));
  // Number of groups for which a part gets memory: twice the average, because parts in the head's middle have more.
  const std::size_t capacity = 2 * std::min(2 * kRows * kRows * count, kGroups) / parts_.size() + Groups::kPadding;
  for (Groups& part : parts_) {
    part.x.assign(capacity, 0);
    part.y.assign(capacity, 0);
    part.z.assign(capacity, 0);
    part.at.assign(capacity, 0);
    part.length.assign(capacity, 0);
    part.label.assign(capacity, 0);
    part.found.assign(capacity, {});
  }
}

void CutFront::Groups::sort(int listed) noexcept {
  const auto bin = [](const Found& group) {
    return static_cast<std::size_t>((group.kind * 2 + group.narrow) * kStages + group.stage);
  };
  std::array<int, kKinds * 2 * kStages> next{};
  for (int i = 0; i < listed; ++i) ++next[bin(found[static_cast<std::size_t>(i)])];
  run_count = 0;
  int from = 0;
  for (int i = 0; i < kKinds * 2 * kStages; ++i) {
    const int size = std::exchange(next[static_cast<std::size_t>(i)], from);
    if (size > 0)
      runs[static_cast<std::size_t>(run_count++)] = {i / (2 * kStages), i / kStages % 2 != 0, i % kStages, from,
                                                     from + size};
    from += size;
  }
  for (int i = 0; i < listed; ++i) {
    const Found& group = found[static_cast<std::size_t>(i)];
    const auto to = static_cast<std::size_t>(next[bin(group)]++);
    x[to] = group.x, y[to] = group.y, z[to] = group.z, at[to] = group.at;
    label[to] = group.label, length[to] = group.length;
  }
  count = listed;
}

void CutFront::Groups::renew(int listed, double path_length, double valid_for) noexcept {
  if (listed > capacity()) return;
  sort(listed);
  until = path_length + valid_for;
  lasts = valid_for;
}

bool CutFront::holds(const glm::ivec3& lo, const glm::ivec3& hi) const noexcept {
  return glm::all(glm::lessThan(blocks(hi, kRows, kRowLength) - blocks(lo, kRows, kRowLength), size_));
}

void CutFront::advance_to(const Pose& X_V, double travel) noexcept {
  X_V_ = X_V;
  path_length_ += travel;
  if (path_length_ < kRound) return;
  for (float& due : due_) due -= static_cast<float>(path_length_);
  for (Groups& part : parts_) part.until -= path_length_;
  path_length_ = 0;
}

void CutFront::move_around(const glm::ivec3& lo, const glm::ivec3& hi) noexcept {
  const glm::ivec3 from = blocks(lo, kRows, kRowLength), to = blocks(hi, kRows, kRowLength);
  const bool inside = glm::all(glm::lessThanEqual(first_, from)) && glm::all(glm::lessThan(to - first_, size_));
  if (known_ && inside) return;
  const glm::ivec3 first = from - (size_ - (to - from + 1)) / 2, shift = first - first_;
  std::fill(moved_.begin(), moved_.end(), -kNever);
  if (known_) {
    // Copies the data of the blocks a ≤ index < b, which stay in the box. Indices are those before the box was moved.
    const glm::ivec3 a = glm::max(shift, 0), b = glm::min(size_ + shift, size_);
    for (int x = a.x; x < b.x; ++x) {
      for (int y = a.y; y < b.y; ++y) {
        if (a.z >= b.z) break;
        const float* const row = due_.data() + (x * size_.y + y) * size_.z;
        const glm::ivec3 at = glm::ivec3(x, y, a.z) - shift;
        std::copy(row + a.z, row + b.z, moved_.data() + (at.x * size_.y + at.y) * size_.z + at.z);
      }
    }
  }
  due_.swap(moved_);
  first_ = first;
  for (Groups& part : parts_) {
    if (!known_) part.until = -1;
    const glm::ivec3 by = shift * glm::ivec3(kRows, kRows, kRowLength);
    const int by_at = (by.x * listed_n_ + by.y) * listed_n_ + by.z;
    for (int i = 0; i < part.count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      part.x[at] -= static_cast<float>(by.x), part.y[at] -= static_cast<float>(by.y);
      part.z[at] -= by.z, part.at[at] -= by_at;
    }
  }
  known_ = true;
}

void CutFront::keep_listed(const glm::ivec3& patch_lo, int n, bool holds) noexcept {
  if (listed_n_ != n || (listed_lo_ != patch_lo && !holds)) drop_listed();
  listed_lo_ = patch_lo;
  listed_n_ = n;
}

int CutFront::outdated() const noexcept {
  return static_cast<int>(
      std::count_if(parts_.begin(), parts_.end(), [&](const Groups& part) { return path_length_ > part.until; }));
}

int CutFront::renewed_early(double travel) const noexcept {
  if (outdated() > 0 || !(travel > 0)) return -1;
  std::array<double, kMaxParts> ticks_left;
  for (std::size_t i = 0; i < parts_.size(); ++i) ticks_left[i] = (parts_[i].until - path_length_) / travel;
  // At most one part's list is renewed early per tick. All lists can be renewed in time if, for every n, at most n of
  // them expire in the next n ticks. Otherwise the list that expires first is renewed now.
  const auto end = ticks_left.begin() + static_cast<std::ptrdiff_t>(parts_.size());
  const auto soonest = std::min_element(ticks_left.begin(), end);
  const std::ptrdiff_t part = soonest - ticks_left.begin();
  std::sort(ticks_left.begin(), end);
  for (std::size_t n = 0; n < parts_.size(); ++n) {
    if (ticks_left[n] < static_cast<double>(n)) return static_cast<int>(part);
  }
  return -1;
}

CutFront::Renewal::Renewal(const CutFront& front, const Blocks& reached, double travel, double listed) noexcept
    : front_(front),
      first_part_(front.part_of(reached.first.x)),
      layers_(reached.last.x - reached.first.x + 1),
      most_(std::max(std::min(layers_, front.parts()) / 8, 1)),
      // A fast head gets no lists of samples, because a list would be valid for a few ticks only.
      ahead_(travel > kMaxListed || front.lanes_ == 0 ? 0 : listed / std::clamp(front.outdated(), 1, most_)),
      ahead_of_empty_(ahead_ > 0 ? listed / std::max(front.outdated(), 1) : 0),
      early_(ahead_ > 0 ? front.renewed_early(travel) : -1) {}

double CutFront::Renewal::lasts(int part) noexcept {
  const bool reached = ((part - first_part_) & (front_.parts() - 1)) < layers_;
  if (!reached) return ahead_of_empty_ * ++empty_;
  return made_ < most_ ? ahead_ * ++made_ : 0;
}

}  // namespace typodont::haptics
