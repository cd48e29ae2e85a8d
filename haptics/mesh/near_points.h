// A list of the points near a head, and a search in this list for points within a distance of a position.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::haptics::mesh {

/// A list of points. Each point is stored as doubles and also as floats, so that eight points can be tested at once.
/// Servo thread; allocates only at construction. Equal calls give equal bits on every processor.
class NearPoints {
 public:
  /// `most` is the largest number of points.
  explicit NearPoints(std::size_t most);

  /// Removes all points. `head_W` is the pose of the head for which points will be listed; all points are near it.
  void clear(const Pose& head_W) noexcept;
  /// Adds a point (m, in the workbench frame W). Returns false if the list is full.
  bool add(const dvec3& p_W) noexcept;
  /// Adds a point whose distance (m) from the head at listed_at() is known. Returns false if the list is full.
  bool add(const dvec3& p_W, double distance) noexcept;
  /// Removes the points from index `first` to the end, except those whose indices are in `kept` (in increasing order).
  /// `distances` has the distance (m) of each kept point from the head at the pose listed_at(). The list stores these
  /// distances.
  void keep(std::size_t first, std::span<const std::uint32_t> kept, std::span<const double> distances) noexcept;

  /// Returns the number of this list. Each call of clear() increases the number, so different lists have different
  /// numbers.
  std::uint64_t number() const noexcept { return number_; }
  std::size_t size() const noexcept { return points_.size(); }
  bool empty() const noexcept { return points_.empty(); }
  bool full() const noexcept { return points_.size() == most_; }
  const dvec3& operator[](std::size_t i) const noexcept { return points_[i]; }
  /// Returns the pose of the head for which the points are listed.
  const Pose& listed_at() const noexcept { return listed_at_; }

  /// Returns the indices, in increasing order, of all points within `reach` (m) of p. Some points that are slightly
  /// farther away may be included. The result is valid until the next call.
  std::span<const std::uint32_t> within(const dvec3& p_W, double reach) noexcept;
  /// Returns the indices, in increasing order, of all points whose stored distance is at most `far` (m), and of the
  /// points without a stored distance. The result is valid until the next call.
  std::span<const std::uint32_t> listed_within(double far) noexcept;

 private:
  std::size_t most_;
  std::uint64_t number_ = 0;
  Pose listed_at_;
  std::vector<dvec3> points_;  // m, in W
  // Coordinates in m relative to the position of listed_at_. The arrays are longer than `points_`, because the last
  // batch is read completely.
  std::vector<float> x_, y_, z_;
  // m, distance of each point from the head at the pose listed_at_; a large negative value means that the distance is
  // not known
  std::vector<float> distance_;
  std::vector<std::uint32_t> at_;  // indices of the points that the last search found
};

}  // namespace typodont::haptics::mesh
