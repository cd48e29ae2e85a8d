// Computes the signed distances from a head to many points at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "haptics/contact/vertex/vertex_head.h"
#include "haptics/mesh/near_points.h"

namespace typodont::haptics::vertex {

/// Computes the distances of eight points at the same time. On every processor, the results have the same bits as
/// those of VertexHead::distance(), except extrapolated results. Any thread; allocates memory only at
/// construction.
class HeadDistances {
 public:
  static constexpr std::size_t kBatch = 8;
  /// The points that the last call has kept, as arrays. The arrays have kBatch more elements than `count`.
  struct Columns {
    const double *distance, *n_x, *n_y, *n_z;
    std::size_t count;
  };

  /// `most`: largest number of points in one call. `reuse`: if a head has moved by less than this ratio of its radius
  /// since the distances of listed points were computed, find() extrapolates them; 0: never.
  explicit HeadDistances(std::size_t most, double reuse = 0);

  /// Finds the listed points that are at most `far` metres from a head at X_WG, in the order of the list. Points that
  /// are certainly farther away than `far`, according to the distances stored in the list, are skipped.
  ///
  /// An extrapolated distance is the linear approximation of the distance, which is a convex function because heads are
  /// convex. So the distance is never overestimated. For a smooth part of a head whose radius of curvature is r, it is
  /// underestimated by at most m²/2r after a motion m. `exact`: true: no distance is extrapolated.
  void find(const VertexHead& head, mesh::NearPoints& points, const Pose& X_WG, double far,
            bool exact = false) noexcept;
  /// Finds the points that are inside a head after it has moved from X_WG by `motion_W` (m). The distances are
  /// extrapolated linearly: a point is found if its distance is smaller than the component of the motion along the
  /// gradient, and this component is positive. Needs `reuse`.
  void find_pushed(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG,
                   const dvec3& motion_W) noexcept;
  /// Returns the number of points whose distances were computed for extrapolation since count_anew().
  std::size_t computed() const noexcept { return computed_; }
  void count_anew() noexcept { computed_ = 0; }
  /// Call this when find() is used for another list. It forgets the distances from which find() extrapolates.
  void forget() noexcept { known_list_ = 0; }
  /// Examines the listed points with an index of at least `first`. Removes those that are farther than `far` metres
  /// from the head at points.listed_at(). Stores the distances of the remaining points in the list.
  void keep_within(const VertexHead& head, mesh::NearPoints& points, std::size_t first, double far) noexcept;

  // The next functions compute distances of points that are in no list. Call clear(), then add() for each point, then
  // evaluate().
  void clear() noexcept { size_ = 0; }
  bool full() const noexcept { return size_ == most_; }
  /// Adds a point with a freely chosen index, at `off_W` (m, frame W) from the head's centre.
  void add(std::uint32_t index, const dvec3& off_W) noexcept {
    index_[size_] = index;
    x_[size_] = off_W.x, y_[size_] = off_W.y, z_[size_] = off_W.z;
    ++size_;
  }
  /// Keeps the added points whose distance from a head in this orientation is at most `far` (m).
  void evaluate(const VertexHead& head, const glm::dmat3& R_WT, double far) noexcept;

  /// Returns the largest number of points in one call.
  std::size_t most() const noexcept { return most_; }
  std::size_t size() const noexcept { return size_; }
  Columns columns() const noexcept { return {distance_.data(), n_x_.data(), n_y_.data(), n_z_.data(), size_}; }
  /// Returns the points that were kept, as indices in `points`.
  std::span<const std::uint32_t> kept() const noexcept { return {index_.data(), size_}; }
  std::uint32_t point(std::size_t i) const noexcept { return index_[i]; }
  /// Returns the signed distance of kept point i, m, negative inside the head.
  double distance(std::size_t i) const noexcept { return distance_[i]; }
  /// Returns the unit direction (frame W) in which the distance of kept point i increases.
  dvec3 normal_W(std::size_t i) const noexcept { return {n_x_[i], n_y_[i], n_z_[i]}; }

 private:
  void compute_all(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG) noexcept;
  void know(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG) noexcept;
  void extrapolate(const Pose& X_WG, double far, const dvec3& motion_W) noexcept;

  std::size_t most_, size_ = 0;
  double reuse_;
  std::vector<std::uint32_t> index_;
  std::vector<double> x_, y_, z_;  // m, frame W, positions of the points relative to the head's centre
  std::vector<double> distance_, n_x_, n_y_, n_z_;
  // Distances of all listed points from a head at one pose, from which find() extrapolates. The arrays are empty if
  // find() never extrapolates.
  std::uint64_t known_list_ = 0;  // number of the list to which the points belong
  std::size_t known_ = 0;         // number of points
  std::size_t computed_ = 0;      // number of points whose distances were computed since count_anew()
  Pose known_at_;                 // pose of the head
  // m, frame T: positions p of the points, their distances d, and unit vectors g in which the distances increase
  std::vector<float> p_x_, p_y_, p_z_, d_, g_x_, g_y_, g_z_;
};

}  // namespace typodont::haptics::vertex
