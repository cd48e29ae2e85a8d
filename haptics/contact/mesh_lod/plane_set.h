// A set of planes that limits a point's position. Finds the allowed position nearest to a goal.
#pragma once

#include <array>
#include <cstdint>

#include "haptics/contact/proxy/active_set.h"

namespace typodont::haptics::mesh_lod {

/// A plane allows the points x with n · (x - c) >= -gap, where c is a common centre. SI units.
struct Plane {
  dvec3 n{0};               // unit normal
  double gap = 0;           // m, distance that the point may move from the centre c against n
  dvec3 p{0};               // m, point where the tool touches the surface
  std::uint64_t order = 0;  // if several planes are equally violated, the one with the lowest order is used
  std::uint32_t face = 0;   // index of the face that gives the plane
  // if the plane is a wall between two tissues: index of the face's edge that is the wall; otherwise -1
  std::int8_t wall = -1;
};

class PlaneSet {
 public:
  static constexpr int kMost = 2048;

  void clear() noexcept { count_ = 0; }
  /// Returns false if the set is full.
  bool add(const Plane& plane) noexcept {
    if (count_ == kMost) return false;
    planes_[static_cast<std::size_t>(count_++)] = plane;
    return true;
  }
  int count() const noexcept { return count_; }
  const Plane& operator[](int i) const noexcept { return planes_[static_cast<std::size_t>(i)]; }
  Plane& operator[](int i) noexcept { return planes_[static_cast<std::size_t>(i)]; }

  /// Displacement from the centre c to the allowed point nearest to `goal`; zero if no point is allowed. `active`:
  /// receives the limiting planes and their Lagrange multipliers (pushes, m).
  dvec3 nearest_allowed(const dvec3& goal, ActivePlanes& active) const noexcept;

 private:
  std::array<Plane, kMost> planes_;
  int count_ = 0;
};

}  // namespace typodont::haptics::mesh_lod
