// The points around a head, and a search for those within a distance of a point.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::haptics::mesh {

/// Points by their index, stored as doubles and also as arrays of floats, so that eight points are tested at once.
/// Servo thread; allocates only at construction. Equal calls give equal bits on every processor.
class NearPoints {
 public:
  /// `most`: limit of the number of points.
  explicit NearPoints(std::size_t most);

  /// Removes all points. `center`: m, W, a point near all points that will be added.
  void clear(const dvec3& center) noexcept;
  /// Returns false if the list is full.
  bool add(const dvec3& p_W) noexcept;
  /// Removes the points from index `first` on, except those listed in `kept`, whose indices increase.
  void keep(std::size_t first, std::span<const std::uint32_t> kept) noexcept;

  std::size_t size() const noexcept { return points_.size(); }
  bool empty() const noexcept { return points_.empty(); }
  bool full() const noexcept { return points_.size() == most_; }
  const dvec3& operator[](std::size_t i) const noexcept { return points_[i]; }

  /// The indices, increasing, of all points within `reach` (m) of p, and of some slightly farther ones. Valid until the
  /// next call.
  std::span<const std::uint32_t> within(const dvec3& p_W, double reach) noexcept;

 private:
  std::size_t most_;
  dvec3 center_{0};
  std::vector<dvec3> points_;  // m, W
  std::vector<float> x_, y_,
      z_;  // m, relative to center_; the arrays are longer than `points_`, because the last batch is read as a whole
  std::vector<std::uint32_t> at_;  // indices of the points found
};

}  // namespace typodont::haptics::mesh
