// Bounding volumes of spheres that may shrink, move and disappear.
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

/// Neighbours in space have near places, also in memory. place = leaf · 8 + lane.
enum class Place : std::int32_t {};

/// Eight spheres per leaf, eight children per node, tested together. m, any frame. After set-up noexcept, no
/// allocation. One thread at a time.
class SphereTree {
 public:
  static constexpr std::size_t kWide = 8;
  static constexpr std::size_t kDeepest = 10;  // levels: 8^10 leaves

  struct Hit {
    double t = kNever;  // 0..1 of the motion; kNever: none
    int sphere = -1;
    explicit operator bool() const { return sphere >= 0; }
  };

  SphereTree(std::span<const dvec3> center, std::span<const double> radius);

  std::size_t size() const { return place_of_.size(); }
  /// Leaves × 8; the last may be empty.
  std::size_t places() const { return sphere_in_.size(); }
  Place place_of(int i) const noexcept { return place_of_[static_cast<std::size_t>(i)]; }
  /// At a place.
  int sphere_in(Place place) const noexcept { return sphere_in_[static_cast<std::size_t>(place)]; }
  dvec3 center(Place place) const noexcept {
    const auto s = static_cast<std::size_t>(place);
    const Leaf& leaf = leaves_[s / kWide];
    return {leaf.x[s % kWide], leaf.y[s % kWide], leaf.z[s % kWide]};
  }
  dvec3 center(int i) const noexcept { return center(place_of(i)); }
  /// 0: disappeared.
  double radius(Place place) const noexcept {
    const auto s = static_cast<std::size_t>(place);
    return leaves_[s / kWide].r[s % kWide];
  }
  double radius(int i) const noexcept { return radius(place_of(i)); }

  /// Radius 0: disappears. Updates the boxes above.
  void set(int i, const dvec3& center, double radius) noexcept {
    put(place_of(i), center, radius);
    mend_above(place_of(i));
  }
  /// Without boxes: mend_above() for one sphere per changed leaf, before the next search.
  void put(Place place, const dvec3& center, double radius) noexcept {
    const auto s = static_cast<std::size_t>(place);
    Leaf& leaf = leaves_[s / kWide];
    leaf.x[s % kWide] = center.x, leaf.y[s % kWide] = center.y, leaf.z[s % kWide] = center.z;
    leaf.r[s % kWide] = radius;
  }
  /// Same leaf.
  bool share_leaf(Place a, Place b) const noexcept {
    return static_cast<std::size_t>(a) / kWide == static_cast<std::size_t>(b) / kWide;
  }
  void mend_above(Place place) noexcept { mend(static_cast<std::size_t>(place) / kWide, /*exactly=*/true); }
  /// If too small. Too large only slows searches.
  void widen_above(Place place) noexcept { mend(static_cast<std::size_t>(place) / kWide, /*exactly=*/false); }

  /// First touched by `r` at `p` moving by `m`; simultaneous: lowest index. Bits of brute_force().
  Hit first_hit(const dvec3& p, double r, const dvec3& m) const noexcept;
  Hit brute_force(const dvec3& p, double r, const dvec3& m) const noexcept;
  /// first_hit() among the given (at most kWide), same bits.
  Hit first_of(std::span<const Place> spheres, const dvec3& p, double r, const dvec3& m) const noexcept;

  /// Places nearer than `reach` to a–b, in an order of the tree's only. Returns how many, also without room in `found`.
  std::size_t near_segment(const dvec3& a, const dvec3& b, double reach, std::span<Place> found) const noexcept;

  /// In parts, between which spheres may change.
  class PartSearch {
   public:
    bool done() const { return depth_ == 0; }

   private:
    friend class SphereTree;
    // level and index, still to visit
    std::array<std::pair<std::uint32_t, std::uint32_t>, kDeepest*(kWide - 1) + 1> stack_;
    std::size_t depth_ = 0;
  };
  PartSearch start_search() const noexcept {
    PartSearch search;
    search.stack_[search.depth_++] = {static_cast<std::uint32_t>(level_.size()), 0};
    return search;
  }
  /// Surfaces nearer than `reach` to p, in near_segment()'s order: places to `found`, distances minus `offset` (m) to
  /// `gap`. Until `leaves` are used, or room may run out. Returns how many.
  std::size_t search_on(PartSearch& search, const dvec3& p, double reach, double offset, std::size_t& leaves,
                        std::span<Place> found, float* gap) const noexcept;

  /// Of the given (at most kWide), what near_segment() finds.
  unsigned near_of(std::span<const Place> spheres, const dvec3& a, const dvec3& b, double reach) const noexcept;
  /// Order of near_segment().
  std::uint32_t rank(int i) const noexcept {
    constexpr auto kLanes = static_cast<std::uint32_t>(kWide);
    const auto place = static_cast<std::uint32_t>(place_of(i));
    const auto last = static_cast<std::uint32_t>(leaves_.size()) - 1;
    return (last - place / kLanes) * kLanes + place % kLanes;
  }

  /// m to the nearest surface, up to `most`, negative inside. At most `enough`: any value in between.
  double room(const dvec3& p, double most, double enough = -kNever) const noexcept;

  /// Ends at the first.
  bool touches(const dvec3& p, double r) const noexcept;

  /// Nearest surface, first in the tree's order; -1: none left.
  int nearest(const dvec3& p) const noexcept;

  std::size_t bytes() const {
    return leaves_.size() * sizeof(Leaf) + nodes_.size() * sizeof(Node) + 2 * place_of_.size() * sizeof(int);
  }

  // Public for the kernels.
  struct alignas(64) Leaf {
    double x[kWide], y[kWide], z[kWide], r[kWide];
  };
  /// Of the given (at most kWide); radius 0: unused.
  Leaf lanes_of(std::span<const Place> spheres) const noexcept {
    Leaf lanes{};
    for (std::size_t k = 0; k < spheres.size(); ++k) {
      const auto s = static_cast<std::size_t>(spheres[k]), i = s % kWide;
      const Leaf& leaf = leaves_[s / kWide];
      lanes.x[k] = leaf.x[i], lanes.y[k] = leaf.y[i], lanes.z[k] = leaf.z[i], lanes.r[k] = leaf.r[i];
    }
    return lanes;
  }
  /// Of children, from origin_, rounded outward; lo > hi: empty.
  struct alignas(32) Node {
    float lo[3][kWide], hi[3][kWide];
  };

 private:
  template <class Visit>
  void visit_nearest(const dvec3& p, double& most, Visit&& visit) const noexcept;
  void order(std::span<const dvec3> center, std::size_t from, std::size_t to, std::size_t chunk);
  void mend(std::size_t leaf, bool exactly) noexcept;

  dvec3 origin_{0};
  double slack_ = 0;             // m, above all rounding in single precision
  std::vector<int> sphere_in_;   // or -1
  std::vector<Place> place_of_;  // for each sphere: its place
  std::vector<Leaf> leaves_;
  std::vector<Node> nodes_;         // level above the leaves first, root last
  std::vector<std::size_t> level_;  // for each level: its first index in nodes_
};

}  // namespace typodont::haptics::packing
