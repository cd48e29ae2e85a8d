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

bool Retreat::is_held(const dvec3& c, const dvec3& hand, bool outside, double dt) noexcept {
  using R = RetreatParameters;
  wedged = false;
  outside ? path.begin(c / path_unit) : path.add(c / path_unit);
  const double least = R::far / unit, still = R::still / unit;
  if (square(hand - c) < least * least || square(c - held_at) > still * still) {
    held_at = c;
    held_for = 0;
    return false;
  }
  held_for += dt;
  return held_for >= R::patience;
}

void Retreat::begin(const dvec3& c, const dvec3& hand) noexcept {
  using R = RetreatParameters;
  to = path.nearest(hand / path_unit, (glm::length(hand - c) - R::gain / unit) / path_unit);
  leading = to < path.size();
  wedged = !leading && held_for > R::report_after;
}

bool Retreat::lead(const dvec3& hand, double max_step, dvec3& c) noexcept {
  if (!leading) return false;
  const bool near = glm::length(hand - c) * unit < RetreatParameters::far / 2;
  for (double left = max_step; !near && left > 0 && path.size() > to;) {
    const dvec3 motion = path_unit * path.last() - c;
    const double length = glm::length(motion);
    if (length > left) {
      c += motion * (left / length);
      break;
    }
    c = path_unit * path.last();
    left -= length;
    path.drop_last();
  }
  if (near || path.size() <= to) {
    leading = false;
    held_for = 0;
    path.add(c / path_unit);
  }
  return !near;
}

}  // namespace typodont::haptics
