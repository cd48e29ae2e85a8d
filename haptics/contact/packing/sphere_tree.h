// A bounding volume hierarchy of spheres that may become smaller, move and disappear.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/contact/packing/sphere_pair.h"

namespace typodont::haptics::packing {

/// Position of a sphere in the tree: leaf · 8 + lane. Neighbouring spheres are at neighbouring positions in memory.
enum class Place : std::int32_t {};

/// Leaves have eight spheres, nodes eight children; all eight are tested at once. Any frame; lengths in m. After set-up
/// no function throws or allocates. One thread at a time.
class SphereTree {
 public:
  static constexpr std::size_t kLeafSize = 8;
  static constexpr std::size_t kDeepest = 10;  // largest number of levels: 8^10 leaves

  struct Hit {
    double t = kNever;  // fraction 0..1 of the motion at first contact; kNever: no contact
    int sphere = -1;
    explicit operator bool() const { return sphere >= 0; }
  };

  SphereTree(std::span<const dvec3> center, std::span<const double> radius);

  std::size_t size() const { return place_of_.size(); }
  /// Number of positions in the tree: 8 per leaf. The last ones may be empty.
  std::size_t places() const { return sphere_in_.size(); }
  Place place_of(int i) const noexcept { return place_of_[static_cast<std::size_t>(i)]; }
  /// Index of the sphere at a position in the tree.
  int sphere_in(Place place) const noexcept { return sphere_in_[static_cast<std::size_t>(place)]; }
  dvec3 center(Place place) const noexcept {
    const auto s = static_cast<std::size_t>(place);
    const Leaf& leaf = leaves_[s / kLeafSize];
    return {leaf.x[s % kLeafSize], leaf.y[s % kLeafSize], leaf.z[s % kLeafSize]};
  }
  dvec3 center(int i) const noexcept { return center(place_of(i)); }
  /// Radius of the sphere at a position in the tree; 0: the sphere has disappeared.
  double radius(Place place) const noexcept {
    const auto s = static_cast<std::size_t>(place);
    return leaves_[s / kLeafSize].r[s % kLeafSize];
  }
  double radius(int i) const noexcept { return radius(place_of(i)); }

  /// Moves and resizes a sphere; radius 0 removes it. Updates the bounding boxes around it.
  void set(int i, const dvec3& center, double radius) noexcept {
    put(place_of(i), center, radius);
    mend_above(place_of(i));
  }
  /// Like set(), but keeps the bounding boxes. Before the next search, call mend_above() once per changed leaf.
  void put(Place place, const dvec3& center, double radius) noexcept {
    const auto s = static_cast<std::size_t>(place);
    Leaf& leaf = leaves_[s / kLeafSize];
    leaf.x[s % kLeafSize] = center.x, leaf.y[s % kLeafSize] = center.y, leaf.z[s % kLeafSize] = center.z;
    leaf.r[s % kLeafSize] = radius;
  }
  /// Returns true if both positions in the tree are in the same leaf.
  bool share_leaf(Place a, Place b) const noexcept {
    return static_cast<std::size_t>(a) / kLeafSize == static_cast<std::size_t>(b) / kLeafSize;
  }
  void mend_above(Place place) noexcept { mend(static_cast<std::size_t>(place) / kLeafSize, /*exactly=*/true); }
  /// Enlarges the bounding boxes above a sphere if they are too small. Boxes that are too large only slow searches.
  void widen_above(Place place) noexcept { mend(static_cast<std::size_t>(place) / kLeafSize, /*exactly=*/false); }

  /// First sphere that a ball of radius `r` at `p` touches when it moves by `m`; of simultaneous ones, that with the
  /// lowest index.
  Hit first_hit(const dvec3& p, double r, const dvec3& m) const noexcept;
  /// first_hit() among the given spheres (at most kLeafSize). Bit-identical to first_hit() if its result is among them.
  Hit first_of(std::span<const Place> spheres, const dvec3& p, double r, const dvec3& m) const noexcept;

  /// Lists the spheres nearer than `reach` to the segment a–b, in the tree's order. Returns their number, also if
  /// `found` is too small.
  std::size_t near_segment(const dvec3& a, const dvec3& b, double reach, std::span<Place> found) const noexcept;

  /// A search in several calls, between which spheres may change.
  class PartSearch {
   public:
    bool done() const { return depth_ == 0; }

   private:
    friend class SphereTree;
    // nodes that remain to be visited: level and index
    std::array<std::pair<std::uint32_t, std::uint32_t>, kDeepest*(kLeafSize - 1) + 1> stack_;
    std::size_t depth_ = 0;
  };
  PartSearch start_search() const noexcept {
    PartSearch search;
    search.stack_[search.depth_++] = {static_cast<std::uint32_t>(level_.size()), 0};
    return search;
  }
  /// Continues a search for spheres whose surfaces are nearer than `reach` to p. Stores their positions in `found`, and
  /// their distances minus `offset` (m) in `gap`, in the order of near_segment(). Stops after `leaves` leaves, or when
  /// `found` may be full.
  std::size_t search_on(PartSearch& search, const dvec3& p, double reach, double offset, std::size_t& leaves,
                        std::span<Place> found, float* gap) const noexcept;

  /// Bit mask of the given spheres (at most kLeafSize) that near_segment() would find.
  unsigned near_of(std::span<const Place> spheres, const dvec3& a, const dvec3& b, double reach) const noexcept;

  /// Distance from p to the nearest sphere's surface, m, at most `most`, negative inside. If the distance is at most
  /// `enough`, may return any value between the distance and `enough`.
  double clearance(const dvec3& p, double most, double enough = -kNever) const noexcept;

  /// Returns true if a ball (`p`, radius `r`) touches a sphere.
  bool touches(const dvec3& p, double r) const noexcept;

  /// Sphere with the surface nearest to p (the first in the tree's order); -1: there is none.
  int nearest(const dvec3& p) const noexcept;

  // Public because the SIMD kernels use it.
  struct alignas(64) Leaf {
    double x[kLeafSize], y[kLeafSize], z[kLeafSize], r[kLeafSize];
  };
  /// Copies the given spheres (at most kLeafSize) to the lanes of a leaf; radius 0: unused lane.
  Leaf lanes_of(std::span<const Place> spheres) const noexcept {
    Leaf lanes{};
    for (std::size_t k = 0; k < spheres.size(); ++k) {
      const auto s = static_cast<std::size_t>(spheres[k]), i = s % kLeafSize;
      const Leaf& leaf = leaves_[s / kLeafSize];
      lanes.x[k] = leaf.x[i], lanes.y[k] = leaf.y[i], lanes.z[k] = leaf.z[i], lanes.r[k] = leaf.r[i];
    }
    return lanes;
  }
  /// Bounding boxes of a node's children relative to origin_, rounded outward; lo > hi: empty.
  struct alignas(32) Node {
    float lo[3][kLeafSize], hi[3][kLeafSize];
  };

 private:
  template <class Visit>
  void visit_nearest(const dvec3& p, double& most, Visit&& visit) const noexcept;
  void order(std::span<const dvec3> center, std::size_t from, std::size_t to, std::size_t chunk);
  void mend(std::size_t leaf, bool exactly) noexcept;

  dvec3 origin_{0};
  double rounding_margin_ = 0;   // m, larger than all rounding errors in single precision
  std::vector<int> sphere_in_;   // index of the sphere at each position in the tree; -1: empty
  std::vector<Place> place_of_;  // for each sphere: its position in the tree
  std::vector<Leaf> leaves_;
  std::vector<Node> nodes_;         // nodes by level, from above the leaves to the root
  std::vector<std::size_t> level_;  // for each level: its first index in nodes_
};

}  // namespace typodont::haptics::packing
