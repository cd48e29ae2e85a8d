// Computes the signed distances from a head to many points at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/mesh/near_points.h"

namespace typodont::haptics::vertex {

/// Computes the distances of eight points at the same time. The results have the same bits as those of
/// VertexHead::distance(), on every processor. Servo thread; allocates memory only at construction.
class HeadDistances {
 public:
  /// `most`: largest number of points in one call.
  explicit HeadDistances(std::size_t most);

  /// Computes the distances of the listed points from a head at the pose X_WG. Keeps the points that are at most `far`
  /// metres from the head, in the same order. `listed`: indices of the points in `points`.
  void find(const VertexHead& head, const mesh::NearPoints& points, std::span<const std::uint32_t> listed,
            const Pose& X_WG, double far) noexcept;

  /// Returns the largest number of points in one call.
  std::size_t most() const noexcept { return most_; }
  std::size_t size() const noexcept { return size_; }
  /// Returns the points that were kept, as indices in `points`.
  std::span<const std::uint32_t> kept() const noexcept { return {index_.data(), size_}; }
  std::uint32_t point(std::size_t i) const noexcept { return index_[i]; }
  /// Returns the signed distance of kept point i, m, negative inside the head.
  double distance(std::size_t i) const noexcept { return distance_[i]; }
  /// Returns the unit direction (frame W) in which the distance of kept point i increases.
  dvec3 normal_W(std::size_t i) const noexcept { return {n_x_[i], n_y_[i], n_z_[i]}; }

 private:
  std::size_t most_, size_ = 0;
  std::vector<std::uint32_t> index_;
  std::vector<double> x_, y_, z_;  // m, frame W, positions of the points relative to the head's centre
  std::vector<double> distance_, n_x_, n_y_, n_z_;
};

}  // namespace typodont::haptics::vertex
