// The volume of overlap of two spheres (sphere_pair.h) for eight pairs at once. Private to the .cpp files of the
// packing model.
#pragma once

#include "engine/base/units.h"
#include "haptics/lanes.h"

namespace typodont::haptics::packing {

TYPODONT_KERNEL void ball_volumes(const D8& r, D8& volume) {
  volume = 4.0 / 3.0 * kPi * r * r * r;
}

/// Computes lens_volume() of each lane, with the same bits.
TYPODONT_KERNEL void lens_volumes(const D8& r1, const D8& r2, const D8& d, D8& volume) {
  const D8 sum = r1 + r2, off = r1 - r2, in = sum - d;
  D8 whole;
  ball_volumes(r1 < r2 ? r1 : r2, whole);
  const D8 lens = kPi * in * in * (d * d + 2.0 * d * sum - 3.0 * off * off) / (12.0 * d);
  volume = d < sum ? (d <= (off < D8{} ? -off : off) ? whole : lens) : D8{};
}

}  // namespace typodont::haptics::packing
