// Nearest to a goal within planes.
#pragma once

#include <array>
#include <cstdint>

#include "haptics/contact/proxy/active_set.h"

namespace typodont::haptics::mesh_lod {

/// n · (x - c) >= -room, c common. SI.
struct Plane {
  dvec3 n{0};               // unit normal
  double room = 0;          // m from c against n
  dvec3 p{0};               // m, on the surface
  std::uint64_t order = 0;  // lower first of equally violated ones
  std::uint32_t face = 0;   // of its face
  // a wall's edge of the face; -1: no wall
  std::int8_t wall = -1;
};

class PlaneSet {
 public:
  static constexpr int kMost = 2048;

  void clear() noexcept { count_ = 0; }
  /// False: full.
  bool add(const Plane& plane) noexcept {
    if (count_ == kMost) return false;
    planes_[static_cast<std::size_t>(count_++)] = plane;
    return true;
  }
  int count() const noexcept { return count_; }
  const Plane& operator[](int i) const noexcept { return planes_[static_cast<std::size_t>(i)]; }
  Plane& operator[](int i) noexcept { return planes_[static_cast<std::size_t>(i)]; }

  /// From c, nearest to `goal`; zero if impossible. `active`: limiting planes with push, m.
  dvec3 nearest_allowed(const dvec3& goal, ActivePlanes& active) const noexcept;

 private:
  std::array<Plane, kMost> planes_;
  int count_ = 0;
};

}  // namespace typodont::haptics::mesh_lod
