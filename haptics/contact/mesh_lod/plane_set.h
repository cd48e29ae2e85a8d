// A set of planes that constrain a point. Computes the point that satisfies all planes and is nearest to a goal.
#pragma once

#include <array>
#include <cstdint>

#include "haptics/contact/proxy/active_set.h"

namespace typodont::haptics::mesh_lod {

/// A plane constraint. It allows the points x with n · (x - c) >= -room, where c is a reference point that all planes
/// of a set share. SI units.
struct Plane {
  dvec3 n{0};               // unit normal
  double room = 0;          // m, distance that the point may move from c in the direction opposite to n
  dvec3 p{0};               // m, point of the surface that this plane represents
  std::uint64_t order = 0;  // rank of the plane; of two equally violated planes, the one with the lower rank is chosen
  std::uint32_t face = 0;   // index of the face to which the plane belongs
  // if the plane is a wall between tissues: index of the face's edge at the wall; -1: not a wall
  std::int8_t wall = -1;
};

class PlaneSet {
 public:
  static constexpr int kMost = 2048;

  void clear() noexcept { count_ = 0; }
  /// Adds a plane. Returns false if the set is full.
  bool add(const Plane& plane) noexcept {
    if (count_ == kMost) return false;
    planes_[static_cast<std::size_t>(count_++)] = plane;
    return true;
  }
  int count() const noexcept { return count_; }
  const Plane& operator[](int i) const noexcept { return planes_[static_cast<std::size_t>(i)]; }
  Plane& operator[](int i) noexcept { return planes_[static_cast<std::size_t>(i)]; }

  /// Returns the displacement from c that satisfies all planes and is nearest to the displacement `goal`. If no
  /// displacement satisfies all planes, returns zero. `active` receives the planes that limit the result, each with its
  /// push (the distance in m by which the plane holds the point back).
  dvec3 nearest_allowed(const dvec3& goal, ActivePlanes& active) const noexcept;

 private:
  std::array<Plane, kMost> planes_;
  int count_ = 0;
};

}  // namespace typodont::haptics::mesh_lod
