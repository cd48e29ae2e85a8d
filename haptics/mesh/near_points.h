// Points near a head, searched by distance.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::haptics::mesh {

/// Doubles, and floats tested eight at a time. Servo thread; allocates only at construction. Equal bits on every
/// processor.
class NearPoints {
 public:
  /// `most` is the largest number of points.
  explicit NearPoints(std::size_t most);

  /// `head_W`: all points will be near it.
  void clear(const Pose& head_W) noexcept;
  /// m, W; false: full.
  bool add(const dvec3& p_W) noexcept;
  /// `distance`: m from the head at listed_at(); false: full.
  bool add(const dvec3& p_W, double distance) noexcept;
  /// Removes from `first` on, except `kept` (ascending) with their `distances` (m) at listed_at().
  void keep(std::size_t first, std::span<const std::uint32_t> kept, std::span<const double> distances) noexcept;

  /// Increased by clear().
  std::uint64_t number() const noexcept { return number_; }
  std::size_t size() const noexcept { return points_.size(); }
  bool empty() const noexcept { return points_.empty(); }
  bool full() const noexcept { return points_.size() == most_; }
  const dvec3& operator[](std::size_t i) const noexcept { return points_[i]; }
  const Pose& listed_at() const noexcept { return listed_at_; }

  /// Within `reach` (m) of p, ascending, and some just beyond. Valid until the next call.
  std::span<const std::uint32_t> within(const dvec3& p_W, double reach) noexcept;
  /// Stored at most `far` (m), or not stored; ascending. Valid until the next call.
  std::span<const std::uint32_t> listed_within(double far) noexcept;

 private:
  std::size_t most_;
  std::uint64_t number_ = 0;
  Pose listed_at_;
  std::vector<dvec3> points_;  // m, in W
  // m from listed_at_; longer than `points_`: the last batch is read whole
  std::vector<float> x_, y_, z_;
  // m at listed_at_; very negative: unknown
  std::vector<float> distance_;
  std::vector<std::uint32_t> at_;  // indices of the points that the last search found
};

}  // namespace typodont::haptics::mesh
