// A bounding volume hierarchy over spheres that shrink, move and vanish while it is in use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/contact/packing/sphere_pair.h"

namespace typodont::haptics::packing {

/// Eight spheres a leaf, eight children a node, both looked at side by side. Metres, any one frame. Built at set-up;
/// everything else is noexcept and never allocates. One thread at a time.
class SphereTree {
 public:
  struct Hit {
    double t = kNever;  // 0 to 1 of the motion; kNever: none
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
  /// 0 where the sphere has vanished.
  double radius(int i) const noexcept {
    const auto s = static_cast<std::size_t>(slot_of_[static_cast<std::size_t>(i)]);
    return leaves_[s / kWide].r[s % kWide];
  }

  /// A sphere is now here and this large; radius 0: it has vanished. Mends the boxes above it, as far as they change.
  void set(int i, const dvec3& center, double radius) noexcept;

  /// The first sphere that a sphere of radius `r` at `p` touches while it moves by `m`; of several at once the one with
  /// the least number. The same bits as brute_force().
  Hit first_hit(const dvec3& p, double r, const dvec3& m) const noexcept;
  Hit brute_force(const dvec3& p, double r, const dvec3& m) const noexcept;
  /// The first of these at most kWide spheres that it touches, with the same bits.
  Hit first_of(std::span<const int> spheres, const dvec3& p, double r, const dvec3& m) const noexcept;

  /// Numbers of the spheres that come nearer than `reach` to the segment from a to b, in an order that depends on the
  /// tree alone. Returns how many there are; more than `found` holds are counted, not stored.
  std::size_t near_segment(const dvec3& a, const dvec3& b, double reach, std::span<int> found) const noexcept;

  /// Whether sphere i is one that near_segment() lists.
  bool is_near(int i, const dvec3& a, const dvec3& b, double reach) const noexcept;
  /// Where sphere i comes in the lists of near_segment(): by ascending rank.
  std::uint32_t rank(int i) const noexcept {
    constexpr auto kLanes = static_cast<std::uint32_t>(kWide);
    const auto slot = static_cast<std::uint32_t>(slot_of_[static_cast<std::size_t>(i)]);
    const auto last = static_cast<std::uint32_t>(leaves_.size()) - 1;
    return (last - slot / kLanes) * kLanes + slot % kLanes;
  }

  /// How far a point may move before it can be in a sphere: at most `most`, negative inside. m.
  double room(const dvec3& p, double most) const noexcept;

  /// The sphere whose surface is nearest to a point, -1 where all have vanished; of several the one found first in the
  /// tree's order.
  int nearest(const dvec3& p) const noexcept;

  std::size_t bytes() const {
    return leaves_.size() * sizeof(Leaf) + nodes_.size() * sizeof(Node) + 2 * slot_of_.size() * sizeof(int);
  }

  static constexpr std::size_t kWide = 8;

  // For the kernels in the .cpp.
  struct alignas(64) Leaf {
    double x[kWide], y[kWide], z[kWide], r[kWide];
  };
  /// Boxes of the children, from origin_, rounded outward; lo > hi: nothing in it.
  struct alignas(32) Node {
    float lo[3][kWide], hi[3][kWide];
  };

 private:
  template <class Visit>
  void visit_nearest(const dvec3& p, double& most, Visit&& visit) const noexcept;
  void order(std::span<const dvec3> center, std::size_t from, std::size_t to, std::size_t chunk);
  void mend(std::size_t leaf) noexcept;

  dvec3 origin_{0};
  double slack_ = 0;          // m, that boxes are larger by: covers all rounding of single precision
  std::vector<int> id_of_;    // of every slot; slot = leaf · 8 + lane; -1: none
  std::vector<int> slot_of_;  // of every sphere
  std::vector<Leaf> leaves_;
  std::vector<Node> nodes_;         // level by level, that above the leaves first, the root last
  std::vector<std::size_t> level_;  // where each level begins in nodes_
};

}  // namespace typodont::haptics::packing
