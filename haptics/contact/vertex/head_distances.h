// Signed distances from a tool's head to many points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/mesh/near_points.h"

namespace typodont::haptics::vertex {

/// Evaluates eight points at a time, bit-identically on every processor. Without extrapolation, the distances are
/// bit-identical to VertexHead::distance(). Any thread; allocates at construction only.
class HeadDistances {
 public:
  static constexpr std::size_t kBatch = 8;
  /// Distances (m) and gradients that the last find(), find_pushed() or evaluate() has computed. The arrays have kBatch
  /// more elements than `count`.
  struct Columns {
    const double *distance, *n_x, *n_y, *n_z;
    std::size_t count;
  };

  /// `most`: largest number of points per call. `reuse`: motion (head radii) up to which find() extrapolates; 0: never.
  explicit HeadDistances(std::size_t most, double reuse = 0);

  /// Finds the listed points at most `far` metres from a head at X_WG, in the list's order. Unless `exact`, distances
  /// are extrapolated linearly; heads are convex, so extrapolated distances are never too large.
  void find(const VertexHead& head, mesh::NearPoints& points, const Pose& X_WG, double far,
            bool exact = false) noexcept;
  /// Finds the points that the head would contain after its motion `motion_W` (m) from X_WG: their extrapolated
  /// distance is at most max(0, component of this motion along the gradient). Requires `reuse` above 0.
  void find_pushed(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG,
                   const dvec3& motion_W) noexcept;
  /// Number of distances since the last count_anew() that were computed, not extrapolated.
  std::size_t computed() const noexcept { return computed_; }
  void count_anew() noexcept { computed_ = 0; }
  /// Discards the stored distances. Must be called before find() is called with another list.
  void forget() noexcept { known_list_ = 0; }
  /// From index `first` on, removes points farther than `far` (m) from the head at the pose points.listed_at(). Stores
  /// the distances of the remaining points.
  void keep_within(const VertexHead& head, mesh::NearPoints& points, std::size_t first, double far) noexcept;

  // For points that are not in a list: call clear(), add() for each point, evaluate().
  void clear() noexcept { size_ = 0; }
  bool full() const noexcept { return size_ == most_; }
  /// `index`: number of the point, chosen by the caller. `off_W`: vector from the head's centre, m, frame W.
  void add(std::uint32_t index, const dvec3& off_W) noexcept {
    index_[size_] = index;
    x_[size_] = off_W.x, y_[size_] = off_W.y, z_[size_] = off_W.z;
    ++size_;
  }
  /// Computes the distances from a head with the orientation R_WT, and keeps points within `far` (m).
  void evaluate(const VertexHead& head, const glm::dmat3& R_WT, double far) noexcept;

  /// Largest number of points per call.
  std::size_t most() const noexcept { return most_; }
  std::size_t size() const noexcept { return size_; }
  Columns columns() const noexcept { return {distance_.data(), n_x_.data(), n_y_.data(), n_z_.data(), size_}; }
  /// Indices of the points that the last call of find(), find_pushed() or evaluate() kept.
  std::span<const std::uint32_t> kept() const noexcept { return {index_.data(), size_}; }
  std::uint32_t point(std::size_t i) const noexcept { return index_[i]; }
  /// Distance of kept point i from the head, m; negative inside.
  double distance(std::size_t i) const noexcept { return distance_[i]; }
  /// Unit vector at kept point i in whose direction the distance from the head increases, frame W.
  dvec3 normal_W(std::size_t i) const noexcept { return {n_x_[i], n_y_[i], n_z_[i]}; }

 private:
  void compute_all(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG) noexcept;
  void know(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG) noexcept;
  void extrapolate(const Pose& X_WG, double far, const dvec3& motion_W) noexcept;

  std::size_t most_, size_ = 0;
  double reuse_;
  std::vector<std::uint32_t> index_;
  std::vector<double> x_, y_, z_;  // m, vectors from the head's centre to the points, frame W
  std::vector<double> distance_, n_x_, n_y_, n_z_;
  // The following members store the distances at pose known_at_, from which find() extrapolates.
  std::uint64_t known_list_ = 0;  // NearPoints::number() of the list
  std::size_t known_ = 0;         // number of points with a stored distance
  std::size_t computed_ = 0;      // number of distances computed since the last count_anew()
  Pose known_at_;                 // pose of the head for the stored distances
  // For each listed point in frame T: position p (m), distance d from the head (m), gradient g of the distance.
  std::vector<float> p_x_, p_y_, p_z_, d_, g_x_, g_y_, g_z_;
};

}  // namespace typodont::haptics::vertex
