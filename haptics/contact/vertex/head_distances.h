// Computes the signed distances from a head to many points at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/mesh/near_points.h"

namespace typodont::haptics::vertex {

/// Computes the distances of many points from a head, eight points at the same time. The results have the same bits on
/// every processor. Results that are not extrapolated have the same bits as those of VertexHead::distance(). Any
/// thread; allocates memory only at construction.
class HeadDistances {
 public:
  static constexpr std::size_t kBatch = 8;
  /// The points that the last find(), find_pushed() or evaluate() has found: their signed distances (m) and the
  /// gradients of the distances. Each array has kBatch more elements than `count`.
  struct Columns {
    const double *distance, *n_x, *n_y, *n_z;
    std::size_t count;
  };

  /// `most`: largest number of points in one call. `reuse`: ratio to the head's radius; find() extrapolates stored
  /// distances until the head has moved by this ratio since they were computed. With 0, find() never extrapolates.
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
  /// Finds the points that would be inside the head if it moved from X_WG by `motion_W` (m). The distance of each point
  /// is extrapolated to X_WG. A point is found if this distance is at most the component of the motion along the
  /// gradient of the distance; a negative component counts as 0. Works only if the constructor got a `reuse` above 0.
  void find_pushed(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG,
                   const dvec3& motion_W) noexcept;
  /// Returns how many distances were computed and stored for extrapolation since the last call of count_anew().
  std::size_t computed() const noexcept { return computed_; }
  void count_anew() noexcept { computed_ = 0; }
  /// Discards the stored distances from which find() extrapolates. Call this before find() is used for another list.
  void forget() noexcept { known_list_ = 0; }
  /// Examines the listed points whose index is at least `first`. Removes a point from the list if it is farther than
  /// `far` metres from the head at points.listed_at(). Stores the distances of the remaining points in the list.
  void keep_within(const VertexHead& head, mesh::NearPoints& points, std::size_t first, double far) noexcept;

  // The next functions compute distances of points that are in no list. Call clear(), then add() for each point, then
  // evaluate().
  void clear() noexcept { size_ = 0; }
  bool full() const noexcept { return size_ == most_; }
  /// Adds a point. `index`: any number with which the caller identifies the point. `off_W`: m, vector from the head's
  /// centre to the point, in the workbench frame W.
  void add(std::uint32_t index, const dvec3& off_W) noexcept {
    index_[size_] = index;
    x_[size_] = off_W.x, y_[size_] = off_W.y, z_[size_] = off_W.z;
    ++size_;
  }
  /// Computes the distances of the added points from a head with the orientation R_WT. Keeps the points whose distance
  /// is at most `far` (m).
  void evaluate(const VertexHead& head, const glm::dmat3& R_WT, double far) noexcept;

  /// Returns the largest number of points for which one call can compute distances.
  std::size_t most() const noexcept { return most_; }
  std::size_t size() const noexcept { return size_; }
  Columns columns() const noexcept { return {distance_.data(), n_x_.data(), n_y_.data(), n_z_.data(), size_}; }
  /// Returns the indices of the points that the last call has found, as find() or add() received them.
  std::span<const std::uint32_t> kept() const noexcept { return {index_.data(), size_}; }
  std::uint32_t point(std::size_t i) const noexcept { return index_[i]; }
  /// Returns the signed distance of kept point i, m, negative inside the head.
  double distance(std::size_t i) const noexcept { return distance_[i]; }
  /// Returns the unit direction in which the distance of kept point i increases, in the workbench frame W.
  dvec3 normal_W(std::size_t i) const noexcept { return {n_x_[i], n_y_[i], n_z_[i]}; }

 private:
  void compute_all(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG) noexcept;
  void know(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG) noexcept;
  void extrapolate(const Pose& X_WG, double far, const dvec3& motion_W) noexcept;

  std::size_t most_, size_ = 0;
  double reuse_;
  std::vector<std::uint32_t> index_;
  std::vector<double> x_, y_, z_;  // m, positions of the points relative to the head's centre, in the workbench frame W
  std::vector<double> distance_, n_x_, n_y_, n_z_;
  // The next members describe the stored distances of all listed points from a head at one pose. find() extrapolates
  // from these distances. If find() never extrapolates, the arrays are empty.
  std::uint64_t known_list_ = 0;  // number of the list that contains these points (NearPoints::number())
  std::size_t known_ = 0;         // number of points
  std::size_t computed_ = 0;      // number of distances computed since the last count_anew()
  Pose known_at_;                 // pose of the head
  // For each point, in the tool's frame T: position p (m), distance d from the head (m), and unit vector g, the
  // gradient of d.
  std::vector<float> p_x_, p_y_, p_z_, d_, g_x_, g_y_, g_z_;
};

}  // namespace typodont::haptics::vertex
