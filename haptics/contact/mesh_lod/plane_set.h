// Planes that bound a point, and the point nearest to a goal that all of them allow.
#pragma once

#include <array>
#include <cstdint>

#include "haptics/contact/proxy/active_set.h"

namespace typodont::haptics::mesh_lod {

/// Allows the points x with n · (x - c) >= -room, where c is the point that all planes of a set are seen from. SI.
struct Plane {
  dvec3 n{0};              // unit
  double room = 0;         // m
  dvec3 p{0};              // m, the place on the surface
  std::uint32_t face = 0;  // that it belongs to
  std::int8_t wall = -1;   // the edge of the face on which a wall stands; -1: the face itself
};

class PlaneSet {
 public:
  static constexpr int kMost = 1024;

  void clear() noexcept { count_ = 0; }
  /// False when it is full.
  bool add(const Plane& plane) noexcept {
    if (count_ == kMost) return false;
    planes_[static_cast<std::size_t>(count_++)] = plane;
    return true;
  }
  int count() const noexcept { return count_; }
  const Plane& operator[](int i) const noexcept { return planes_[static_cast<std::size_t>(i)]; }

  /// The displacement from c nearest to `goal` (a displacement, too) that all planes allow, and the planes that hold it
  /// there, pushes in m. Where there is none, no displacement: the point stays.
  dvec3 nearest_allowed(const dvec3& goal, ActivePlanes& active) const noexcept;

 private:
  std::array<Plane, kMost> planes_;
  int count_ = 0;
};

}  // namespace typodont::haptics::mesh_lod
