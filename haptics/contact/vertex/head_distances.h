// Signed distances from a head to many points at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/mesh/near_points.h"

namespace typodont::haptics::vertex {

/// Computes the distances of eight points together. The results equal those of VertexHead::distance() bit for bit, on
/// every processor. Servo thread; allocates only at construction.
class HeadDistances {
 public:
  /// `most`: limit of the number of points in one call.
  explicit HeadDistances(std::size_t most);

  /// Evaluates the listed points, for a head at X_WG, and keeps those that are at most `far` metres from the head.
  /// Keeps their order.
  void find(const VertexHead& head, const mesh::NearPoints& points, std::span<const std::uint32_t> listed,
            const Pose& X_WG, double far) noexcept;

  std::size_t size() const noexcept { return size_; }
  /// Indices in `points` of the points that were kept.
  std::span<const std::uint32_t> kept() const noexcept { return {index_.data(), size_}; }
  std::uint32_t point(std::size_t i) const noexcept { return index_[i]; }
  /// Signed distance, m, negative inside the head.
  double distance(std::size_t i) const noexcept { return distance_[i]; }
  /// Unit direction, W, in which the distance grows.
  dvec3 normal_W(std::size_t i) const noexcept { return {n_x_[i], n_y_[i], n_z_[i]}; }

 private:
  std::size_t size_ = 0;
  std::vector<std::uint32_t> index_;
  std::vector<double> x_, y_, z_;  // m, W, positions of the points relative to the head's centre
  std::vector<double> distance_, n_x_, n_y_, n_z_;
};

}  // namespace typodont::haptics::vertex
