#include "haptics/contact/retreat_path.h"

#include <algorithm>

namespace typodont::haptics {

namespace {

double square(const dvec3& v) {
  return glm::dot(v, v);
}

}  // namespace

/// Sets far_: number of points at the start of the path that are all far from c.
void RetreatPath::find_far_points(const dvec3& c) noexcept {
  far_ = 0;
  far_from_ = c;
  while (far_ < points_.size()) {
    const double off = glm::length(c - points_[far_]) - kSamePlace - kFar;
    if (off <= 0) break;
    far_ += std::max<std::size_t>(1, static_cast<std::size_t>(off / longest_));
  }
  far_ = std::min(far_, points_.size());
}

void RetreatPath::add(const dvec3& c) noexcept {
  if (points_.empty() || square(c - points_.back()) > kLeap * kLeap) return begin(c);
  if (square(c - points_.back()) < kSpacing * kSpacing) return;
  // Searches the first path point near c. If a point is far from c, the next points are far, too, and are skipped.
  if (!(square(c - far_from_) < kFar * kFar)) find_far_points(c);
  std::size_t visited = far_;
  while (visited < points_.size()) {
    const double off = glm::length(c - points_[visited]) - kSamePlace;
    if (off <= 0) break;
    visited += std::max<std::size_t>(1, static_cast<std::size_t>(off / longest_));
  }
  if (visited < points_.size()) {
    points_.resize(visited + 1);
    return;
  }
  if (points_.size() == kMost) {
    for (std::size_t i = 0; i < kMost / 2; ++i) points_[i] = points_[2 * i];
    points_.resize(kMost / 2);
    longest_ *= 2;
    far_ = 0;
  }
  longest_ = std::max(longest_, glm::length(c - points_.back()));
  points_.push_back(c);
}

std::size_t RetreatPath::nearest(const dvec3& target, double within) const noexcept {
  std::size_t best = points_.size();
  double least = within * within;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (const double off = square(points_[i] - target); off < least) least = off, best = i;
  }
  return best;
}

dvec3 RetreatPath::withdrawn(dvec3 c, const dvec3& target, double max_step) noexcept {
  while (max_step > 0 && !points_.empty()) {
    const dvec3 offset = points_.back() - c, pull = target - c;
    const double length = glm::length(offset), along = glm::dot(offset, pull);
    if (length > kSpacing) {
      if (along < kTowards * length * glm::length(pull)) break;
      const double step = std::min({length, along / length, max_step});
      c += offset * (step / length);
      max_step -= step;
      if (step < length) break;
    }
    drop_last();
  }
  return c;
}

}  // namespace typodont::haptics
