// Planes that bound a point, and the point nearest to a goal that satisfies all of them.
#pragma once

#include <array>
#include <cstdint>

#include "haptics/contact/proxy/active_set.h"

namespace typodont::haptics::mesh_lod {

/// A plane. It allows the points x with n · (x - c) >= -room, where c is the common reference point of all planes of
/// a set. SI.
struct Plane {
  dvec3 n{0};              // unit
  double room = 0;         // m
  dvec3 p{0};              // m, point on the surface
  std::uint32_t face = 0;  // index of the face to which the plane belongs
  std::int8_t wall = -1;   // index of the face's edge on which a wall stands; -1: the face itself
};

class PlaneSet {
 public:
  static constexpr int kMost = 1024;

  void clear() noexcept { count_ = 0; }
  /// Adds a plane. Returns false if the set is full.
  bool add(const Plane& plane) noexcept {
    if (count_ == kMost) return false;
    planes_[static_cast<std::size_t>(count_++)] = plane;
    return true;
  }
  int count() const noexcept { return count_; }
  const Plane& operator[](int i) const noexcept { return planes_[static_cast<std::size_t>(i)]; }

  /// Returns the displacement from c that satisfies all planes and is nearest to `goal` (also a displacement).
  /// `active`: receives the planes that hold it, with pushes in m. If no such displacement exists, returns zero.
  dvec3 nearest_allowed(const dvec3& goal, ActivePlanes& active) const noexcept;

 private:
  std::array<Plane, kMost> planes_;
  int count_ = 0;
};

}  // namespace typodont::haptics::mesh_lod
