// Signed distances from a head to many points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/mesh/near_points.h"

namespace typodont::haptics::vertex {

/// Eight at a time, the same bits on every processor; without extrapolation those of VertexHead::distance(). Any
/// thread; allocates at construction only.
class HeadDistances {
 public:
  static constexpr std::size_t kBatch = 8;
  /// Of the last find(), find_pushed() or evaluate(): m, and gradients. kBatch more elements than `count`.
  struct Columns {
    const double *distance, *n_x, *n_y, *n_z;
    std::size_t count;
  };

  /// `most`: points per call. `reuse`: motion, in radii, over which find() extrapolates; 0: never.
  explicit HeadDistances(std::size_t most, double reuse = 0);

  /// Finds the listed points that are at most `far` metres from a head at X_WG, in the order of the list. Distances
  /// that the list stores show which points are certainly farther away; these points are skipped.
  ///
  /// An extrapolated distance is a linear approximation. Heads are convex, so the true distance is a convex function,
  /// and the extrapolated distance is never larger than the true one. At a smooth part of the head with the radius of
  /// curvature r, it is too small by at most m²/2r after a motion of the length m. `exact`: true: no distance is
  /// extrapolated.
  void find(const VertexHead& head, mesh::NearPoints& points, const Pose& X_WG, double far,
            bool exact = false) noexcept;
  /// Points that `motion_W` (m) from X_WG would take in: extrapolated distance at most the motion along the gradient
  /// (not below 0). Needs `reuse` above 0.
  void find_pushed(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG,
                   const dvec3& motion_W) noexcept;
  /// Computed for extrapolation since count_anew().
  std::size_t computed() const noexcept { return computed_; }
  void count_anew() noexcept { computed_ = 0; }
  /// Before find() with another list.
  void forget() noexcept { known_list_ = 0; }
  /// From index `first`: removes points farther than `far` (m) from the head at points.listed_at(), stores the others'
  /// distances.
  void keep_within(const VertexHead& head, mesh::NearPoints& points, std::size_t first, double far) noexcept;

  // Without a list: clear(), add() each, evaluate().
  void clear() noexcept { size_ = 0; }
  bool full() const noexcept { return size_ == most_; }
  /// `index`: the caller's. `off_W`: m, W, from the head's centre.
  void add(std::uint32_t index, const dvec3& off_W) noexcept {
    index_[size_] = index;
    x_[size_] = off_W.x, y_[size_] = off_W.y, z_[size_] = off_W.z;
    ++size_;
  }
  /// With the head at R_WT; keeps those within `far` (m).
  void evaluate(const VertexHead& head, const glm::dmat3& R_WT, double far) noexcept;

  /// Per call.
  std::size_t most() const noexcept { return most_; }
  std::size_t size() const noexcept { return size_; }
  Columns columns() const noexcept { return {distance_.data(), n_x_.data(), n_y_.data(), n_z_.data(), size_}; }
  /// Of the last call, as given to find() or add().
  std::span<const std::uint32_t> kept() const noexcept { return {index_.data(), size_}; }
  std::uint32_t point(std::size_t i) const noexcept { return index_[i]; }
  /// m, negative inside.
  double distance(std::size_t i) const noexcept { return distance_[i]; }
  /// Unit direction of increase, W.
  dvec3 normal_W(std::size_t i) const noexcept { return {n_x_[i], n_y_[i], n_z_[i]}; }

 private:
  void compute_all(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG) noexcept;
  void know(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG) noexcept;
  void extrapolate(const Pose& X_WG, double far, const dvec3& motion_W) noexcept;

  std::size_t most_, size_ = 0;
  double reuse_;
  std::vector<std::uint32_t> index_;
  std::vector<double> x_, y_, z_;  // m, W, from the head's centre
  std::vector<double> distance_, n_x_, n_y_, n_z_;
  // Stored distances at one pose, for extrapolation; otherwise empty.
  std::uint64_t known_list_ = 0;  // NearPoints::number()
  std::size_t known_ = 0;         // number of points
  std::size_t computed_ = 0;      // number of distances computed since the last count_anew()
  Pose known_at_;                 // pose of the head
  // T: position p (m), distance d (m), gradient g.
  std::vector<float> p_x_, p_y_, p_z_, d_, g_x_, g_y_, g_z_;
};

}  // namespace typodont::haptics::vertex
