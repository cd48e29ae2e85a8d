// The functions of sphere_pair.h for eight pairs of spheres at once, with bit-identical results. Only for the .cpp
// files of the packing.
#pragma once

#include "engine/base/pose.h"
#include "engine/base/units.h"
#include "haptics/cutting/lanes.h"

namespace typodont::haptics::packing {

TYPODONT_INLINE void ball_volumes(const D8& r, D8& volume) {
  volume = 4.0 / 3.0 * kPi * r * r * r;
}

/// lens_volume() for eight pairs of spheres at once, with bit-identical results.
TYPODONT_INLINE void lens_volumes(const D8& r1, const D8& r2, const D8& d, D8& volume) {
  const D8 sum = r1 + r2, off = r1 - r2, in = sum - d;
  D8 whole;
  ball_volumes(r1 < r2 ? r1 : r2, whole);
  const D8 lens = kPi * in * in * (d * d + 2.0 * d * sum - 3.0 * off * off) / (12.0 * d);
  volume = d < sum ? (d <= (off < D8{} ? -off : off) ? whole : lens) : D8{};
}

/// Vectors to the points (x, y, z) from their nearest points on the segment a–b.
TYPODONT_INLINE void offsets_from_segment(const D8& x, const D8& y, const D8& z, const dvec3& a, const dvec3& b,
                                          D8& off_x, D8& off_y, D8& off_z) {
  off_x = x - a.x, off_y = y - a.y, off_z = z - a.z;
  const dvec3 ab = b - a;
  if (const double length2 = glm::dot(ab, ab); length2 > 0) {
    const D8 zero{}, at = (off_x * ab.x + off_y * ab.y + off_z * ab.z) / length2, low = at < zero ? zero : at,
                     fraction = low > zero + 1.0 ? zero + 1.0 : low;
    off_x = x - (a.x + fraction * ab.x), off_y = y - (a.y + fraction * ab.y), off_z = z - (a.z + fraction * ab.z);
  }
}

}  // namespace typodont::haptics::packing
