// The points around a head, and which of them lie within a distance of a place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::haptics::mesh {

/// Points by their index, in doubles, and as floats side by side, so that eight are looked at at once. Servo thread;
/// allocates at construction only. Equal calls give equal bits on every processor.
class NearPoints {
 public:
  /// `most`: points that it has room for.
  explicit NearPoints(std::size_t most);

  /// Without points. `center`: m, near all that will be added.
  void clear(const dvec3& center) noexcept;
  /// False when it is full.
  bool add(const dvec3& p_W) noexcept;

  std::size_t size() const noexcept { return points_.size(); }
  bool empty() const noexcept { return points_.empty(); }
  bool full() const noexcept { return points_.size() == most_; }
  const dvec3& operator[](std::size_t i) const noexcept { return points_[i]; }

  /// The indices, rising, of all points within `reach` metres of p, and of some that are a little farther. Valid until
  /// the next call.
  std::span<const std::uint32_t> within(const dvec3& p_W, double reach) noexcept;

 private:
  std::size_t most_;
  dvec3 center_{0};
  std::vector<dvec3> points_;  // m, W
  std::vector<float> x_, y_,
      z_;                          // m from center_; room for a whole batch behind the last
  std::vector<std::uint32_t> at_;  // those within
};

}  // namespace typodont::haptics::mesh
