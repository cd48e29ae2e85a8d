// A bounding volume hierarchy of spheres. Spheres may shrink, move and disappear after the hierarchy was built.
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

/// Place of a sphere in the order of the tree. Spheres that are near each other in space usually have neighbouring
/// places. Data are stored in the order of the places, so they are also near each other in memory. place = leaf · 8 +
/// lane.
enum class Place : std::int32_t {};

/// A tree with eight spheres per leaf and eight children per node, which are tested in parallel. Metres, any frame.
/// Built at set-up; all other functions are noexcept and never allocate. Used by one thread at a time.
class SphereTree {
 public:
  static constexpr std::size_t kWide = 8;
  static constexpr std::size_t kDeepest = 10;  // largest number of levels; a tree with so many levels has 8^10 leaves

  struct Hit {
    double t = kNever;  // fraction 0..1 of the motion at the contact; kNever: no contact
    int sphere = -1;
    explicit operator bool() const { return sphere >= 0; }
  };

  SphereTree(std::span<const dvec3> center, std::span<const double> radius);

  std::size_t size() const { return place_of_.size(); }
  /// Returns the number of places (leaves × 8). The last places may have no sphere.
  std::size_t places() const { return sphere_in_.size(); }
  Place place_of(int i) const noexcept { return place_of_[static_cast<std::size_t>(i)]; }
  /// Returns the index of the sphere at a place.
  int sphere_in(Place place) const noexcept { return sphere_in_[static_cast<std::size_t>(place)]; }
  dvec3 center(Place place) const noexcept {
    const auto s = static_cast<std::size_t>(place);
    const Leaf& leaf = leaves_[s / kWide];
    return {leaf.x[s % kWide], leaf.y[s % kWide], leaf.z[s % kWide]};
  }
  dvec3 center(int i) const noexcept { return center(place_of(i)); }
  /// Returns the radius of a sphere, or 0 if the sphere has disappeared.
  double radius(Place place) const noexcept {
    const auto s = static_cast<std::size_t>(place);
    return leaves_[s / kWide].r[s % kWide];
  }
  double radius(int i) const noexcept { return radius(place_of(i)); }

  /// Sets the position and radius of a sphere; with radius 0 the sphere disappears. Updates the boxes of the nodes
  /// above it.
  void set(int i, const dvec3& center, double radius) noexcept {
    put(place_of(i), center, radius);
    mend_above(place_of(i));
  }
  /// Like set(), but does not update the boxes. The caller calls mend_above() for one sphere of every changed leaf
  /// before the next search.
  void put(Place place, const dvec3& center, double radius) noexcept {
    const auto s = static_cast<std::size_t>(place);
    Leaf& leaf = leaves_[s / kWide];
    leaf.x[s % kWide] = center.x, leaf.y[s % kWide] = center.y, leaf.z[s % kWide] = center.z;
    leaf.r[s % kWide] = radius;
  }
  /// Returns true if two spheres are in the same leaf of the tree.
  bool share_leaf(Place a, Place b) const noexcept {
    return static_cast<std::size_t>(a) / kWide == static_cast<std::size_t>(b) / kWide;
  }
  void mend_above(Place place) noexcept { mend(static_cast<std::size_t>(place) / kWide, /*exactly=*/true); }
  /// Enlarges the boxes above a sphere if they have become too small. Boxes that are larger than necessary make
  /// searches slower, but do not change their results.
  void widen_above(Place place) noexcept { mend(static_cast<std::size_t>(place) / kWide, /*exactly=*/false); }

  /// Returns the first sphere that a sphere of radius `r` at `p` touches while it moves by `m`. Among simultaneous
  /// contacts, returns the sphere with the lowest index. The result has the same bits as that of brute_force().
  Hit first_hit(const dvec3& p, double r, const dvec3& m) const noexcept;
  Hit brute_force(const dvec3& p, double r, const dvec3& m) const noexcept;
  /// Returns the first sphere that the moving sphere touches, as first_hit() does, but tests only the given spheres (at
  /// most kWide). The result has the same bits.
  Hit first_of(std::span<const Place> spheres, const dvec3& p, double r, const dvec3& m) const noexcept;

  /// Writes to `found` the places (indices in the tree) of the spheres that are nearer than `reach` to the segment from
  /// a to b. Their order depends only on the tree. Returns the number of these spheres, including those for which
  /// `found` has no space.
  std::size_t near_segment(const dvec3& a, const dvec3& b, double reach, std::span<Place> found) const noexcept;

  /// State of a search for the spheres around a point. The search is made in parts, between which spheres may change.
  class PartSearch {
   public:
    bool done() const { return depth_ == 0; }

   private:
    friend class SphereTree;
    // level and index (in this level) of the nodes that must still be visited
    std::array<std::pair<std::uint32_t, std::uint32_t>, kDeepest*(kWide - 1) + 1> stack_;
    std::size_t depth_ = 0;
  };
  PartSearch start_search() const noexcept {
    PartSearch search;
    search.stack_[search.depth_++] = {static_cast<std::uint32_t>(level_.size()), 0};
    return search;
  }
  /// Continues a search for the spheres whose surface is nearer than `reach` to p, in the order of near_segment().
  /// Appends their places (indices in the tree) to `found`, and to `gap` the distances from p to their surfaces minus
  /// `offset` (m). Stops after `leaves` leaves of the tree, or when the space in `found` might be too small for the
  /// next leaf. Reduces `leaves` by the number of leaves that it examined. Returns the number of spheres.
  std::size_t search_on(PartSearch& search, const dvec3& p, double reach, double offset, std::size_t& leaves,
                        std::span<Place> found, float* gap) const noexcept;

  /// Returns a bit mask of those of the given spheres (at most kWide) that near_segment() would find.
  unsigned near_of(std::span<const Place> spheres, const dvec3& a, const dvec3& b, double reach) const noexcept;
  /// Returns the rank of sphere i; near_segment() sorts its result by rank.
  std::uint32_t rank(int i) const noexcept {
    constexpr auto kLanes = static_cast<std::uint32_t>(kWide);
    const auto place = static_cast<std::uint32_t>(place_of(i));
    const auto last = static_cast<std::uint32_t>(leaves_.size()) - 1;
    return (last - place / kLanes) * kLanes + place % kLanes;
  }

  /// Returns the distance from a point to the nearest surface of a sphere, m: at most `most`, and negative if the point
  /// is inside a sphere. If the distance is at most `enough`, the search ends early, and the result is any value
  /// between the distance and `enough`.
  double room(const dvec3& p, double most, double enough = -kNever) const noexcept;

  /// Returns true if a ball of radius `r` at `p` overlaps or touches a sphere. The search ends at the first such
  /// sphere.
  bool touches(const dvec3& p, double r) const noexcept;

  /// Returns the sphere whose surface is nearest to a point, or -1 if all spheres have disappeared. Among equally near
  /// spheres, returns the first in the tree's order.
  int nearest(const dvec3& p) const noexcept;

  std::size_t bytes() const {
    return leaves_.size() * sizeof(Leaf) + nodes_.size() * sizeof(Node) + 2 * place_of_.size() * sizeof(int);
  }

  // Public only because the kernels in the .cpp file need it.
  struct alignas(64) Leaf {
    double x[kWide], y[kWide], z[kWide], r[kWide];
  };
  /// Returns centres and radii of the given spheres (at most kWide). The radius of an unused lane is 0.
  Leaf lanes_of(std::span<const Place> spheres) const noexcept {
    Leaf lanes{};
    for (std::size_t k = 0; k < spheres.size(); ++k) {
      const auto s = static_cast<std::size_t>(spheres[k]), i = s % kWide;
      const Leaf& leaf = leaves_[s / kWide];
      lanes.x[k] = leaf.x[i], lanes.y[k] = leaf.y[i], lanes.z[k] = leaf.z[i], lanes.r[k] = leaf.r[i];
    }
    return lanes;
  }
  /// Boxes of the eight children, relative to origin_ and rounded outward. A box with lo > hi is empty.
  struct alignas(32) Node {
    float lo[3][kWide], hi[3][kWide];
  };

 private:
  template <class Visit>
  void visit_nearest(const dvec3& p, double& most, Visit&& visit) const noexcept;
  void order(std::span<const dvec3> center, std::size_t from, std::size_t to, std::size_t chunk);
  void mend(std::size_t leaf, bool exactly) noexcept;

  dvec3 origin_{0};
  double slack_ = 0;             // m, margin of the boxes; larger than all rounding errors of single precision
  std::vector<int> sphere_in_;   // for each place in the tree: index of its sphere, or -1
  std::vector<Place> place_of_;  // for each sphere: its place
  std::vector<Leaf> leaves_;
  std::vector<Node> nodes_;         // all nodes, level by level: the level above the leaves first, the root last
  std::vector<std::size_t> level_;  // for each level: its first index in nodes_
};

}  // namespace typodont::haptics::packing
