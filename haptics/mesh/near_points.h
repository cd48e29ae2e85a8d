// Contact points of the tissue's mesh near a tool's head, with a fast search by distance.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::haptics::mesh {

/// Points as doubles, and as floats that are tested eight at a time. Servo thread only; allocates only at construction.
/// Results are bit-identical on every processor.
class NearPoints {
 public:
  /// `most`: capacity, number of points.
  explicit NearPoints(std::size_t most);

  /// Removes all points. `head_W`: pose of the head, near which the next points are.
  void clear(const Pose& head_W) noexcept;
  /// Adds a point (m, frame W); returns false if full.
  bool add(const dvec3& p_W) noexcept;
  /// Adds a point with its `distance` (m) from the head at the pose listed_at(). Returns false if the list is full.
  bool add(const dvec3& p_W, double distance) noexcept;
  /// Removes the points from index `first` on, except those in `kept` (ascending), which get the `distances` (m) from
  /// the head at the pose listed_at().
  void keep(std::size_t first, std::span<const std::uint32_t> kept, std::span<const double> distances) noexcept;

  /// Number of clear() calls so far, which identifies the current list of points.
  std::uint64_t number() const noexcept { return number_; }
  std::size_t size() const noexcept { return points_.size(); }
  bool empty() const noexcept { return points_.empty(); }
  bool full() const noexcept { return points_.size() == most_; }
  const dvec3& operator[](std::size_t i) const noexcept { return points_[i]; }
  const Pose& listed_at() const noexcept { return listed_at_; }

  /// Indices of the points within `reach` (m) of p_W, ascending; some are slightly farther. Valid until the next call.
  std::span<const std::uint32_t> within(const dvec3& p_W, double reach) noexcept;
  /// Indices of points whose stored distance is at most `far` (m) or unknown, ascending. Valid until the next call.
  std::span<const std::uint32_t> listed_within(double far) noexcept;

 private:
  std::size_t most_;
  std::uint64_t number_ = 0;
  Pose listed_at_;
  std::vector<dvec3> points_;  // m, frame W, positions of the points
  // m, positions relative to listed_at_; longer than `points_`, because eight points are read together
  std::vector<float> x_, y_, z_;
  // m, distance of each point from the head at the pose listed_at_; very negative: unknown
  std::vector<float> distance_;
  std::vector<std::uint32_t> at_;  // indices of the points that the last search found
};

}  // namespace typodont::haptics::mesh
