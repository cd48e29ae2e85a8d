// A bounding volume hierarchy of spheres. Spheres may shrink, move and disappear after it was built.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/contact/packing/sphere_pair.h"

namespace typodont::haptics::packing {

/// A tree with eight spheres per leaf and eight children per node, which are tested in parallel. Metres, any frame.
/// Built at set-up; all other functions are noexcept and never allocate. Used by one thread at a time.
class SphereTree {
 public:
  struct Hit {
    double t = kNever;  // fraction 0..1 of the motion at the contact; kNever: no contact
    int sphere = -1;
    explicit operator bool() const { return sphere >= 0; }
  };

  SphereTree(std::span<const dvec3> center, std::span<const double> radius);

  std::size_t size() const { return slot_of_.size(); }
  dvec3 center(int i) const noexcept {
    const auto s = static_cast<std::size_t>(slot_of_[static_cast<std::size_t>(i)]);
    const Leaf& leaf = leaves_[s / kWide];
    return {leaf.x[s % kWide], leaf.y[s % kWide], leaf.z[s % kWide]};
  }
  /// Returns the radius of sphere i, or 0 if the sphere has disappeared.
  double radius(int i) const noexcept {
    const auto s = static_cast<std::size_t>(slot_of_[static_cast<std::size_t>(i)]);
    return leaves_[s / kWide].r[s % kWide];
  }

  /// Sets the position and radius of a sphere; with radius 0 the sphere disappears. Updates the boxes of the nodes
  /// above it.
  void set(int i, const dvec3& center, double radius) noexcept {
    put(i, center, radius);
    mend_above(i);
  }
  /// Sets position and radius of a sphere as set() does, but does not update the boxes of the nodes. The caller calls
  /// mend_above() for one sphere of every changed leaf before the next search.
  void put(int i, const dvec3& center, double radius) noexcept;
  /// Returns true if two spheres are in the same leaf of the tree.
  bool share_leaf(int i, int j) const noexcept {
    return slot_of_[static_cast<std::size_t>(i)] / static_cast<int>(kWide) ==
           slot_of_[static_cast<std::size_t>(j)] / static_cast<int>(kWide);
  }
  void mend_above(int i) noexcept { mend(static_cast<std::size_t>(slot_of_[static_cast<std::size_t>(i)]) / kWide); }

  /// Returns the first sphere that a sphere of radius `r` at `p` touches while it moves by `m`. Among simultaneous
  /// contacts, returns the sphere with the lowest index. The result has the same bits as that of brute_force().
  Hit first_hit(const dvec3& p, double r, const dvec3& m) const noexcept;
  Hit brute_force(const dvec3& p, double r, const dvec3& m) const noexcept;
  /// Returns the first sphere that the moving sphere touches, as first_hit() does, but tests only the given spheres (at
  /// most kWide). The result has the same bits.
  Hit first_of(std::span<const int> spheres, const dvec3& p, double r, const dvec3& m) const noexcept;

  /// Writes to `found` the indices of the spheres that are nearer than `reach` to the segment from a to b. Their order
  /// depends only on the tree. Returns their number; spheres for which `found` has no space are counted but not
  /// written.
  std::size_t near_segment(const dvec3& a, const dvec3& b, double reach, std::span<int> found) const noexcept;

  /// Returns true if near_segment() with the same arguments finds sphere i.
  bool is_near(int i, const dvec3& a, const dvec3& b, double reach) const noexcept;
  /// Returns the rank of sphere i; near_segment() sorts its result by rank.
  std::uint32_t rank(int i) const noexcept {
    constexpr auto kLanes = static_cast<std::uint32_t>(kWide);
    const auto slot = static_cast<std::uint32_t>(slot_of_[static_cast<std::size_t>(i)]);
    const auto last = static_cast<std::uint32_t>(leaves_.size()) - 1;
    return (last - slot / kLanes) * kLanes + slot % kLanes;
  }

  /// Returns the distance that a point may move before it can be inside a sphere, m: at most `most`; negative if the
  /// point is inside a sphere.
  double room(const dvec3& p, double most) const noexcept;

  /// Returns true if a ball of radius `r` at `p` overlaps or touches a sphere. The search ends at the first such
  /// sphere.
  bool touches(const dvec3& p, double r) const noexcept;

  /// Returns the sphere whose surface is nearest to a point, or -1 if all spheres have disappeared. Among equally near
  /// spheres, returns the first in the tree's order.
  int nearest(const dvec3& p) const noexcept;

  std::size_t bytes() const {
    return leaves_.size() * sizeof(Leaf) + nodes_.size() * sizeof(Node) + 2 * slot_of_.size() * sizeof(int);
  }

  static constexpr std::size_t kWide = 8;

  // Public only because the kernels in the .cpp file need it.
  struct alignas(64) Leaf {
    double x[kWide], y[kWide], z[kWide], r[kWide];
  };
  /// A node of the tree: the boxes of its eight children, relative to origin_ and rounded outward. A box with lo > hi
  /// is empty.
  struct alignas(32) Node {
    float lo[3][kWide], hi[3][kWide];
  };

 private:
  template <class Visit>
  void visit_nearest(const dvec3& p, double& most, Visit&& visit) const noexcept;
  void order(std::span<const dvec3> center, std::size_t from, std::size_t to, std::size_t chunk);
  void mend(std::size_t leaf) noexcept;

  dvec3 origin_{0};
  double slack_ = 0;          // m, margin of the boxes; larger than all rounding errors of single precision
  std::vector<int> id_of_;    // for each slot (place in a leaf): index of its sphere, or -1; slot = leaf · 8 + lane
  std::vector<int> slot_of_;  // for each sphere: index of its slot
  std::vector<Leaf> leaves_;
  std::vector<Node> nodes_;         // all nodes, level by level: the level above the leaves first, the root last
  std::vector<std::size_t> level_;  // for each level: its first index in nodes_
};

}  // namespace typodont::haptics::packing
