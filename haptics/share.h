// The share of a voxel that lies inside a surface, as all of the haptics count it: in whole units, so that volumes are exact
// sums, whatever their order, and what is taken, put down and left over adds up to the last unit.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace typodont::haptics {

inline constexpr double kShareUnit = 1.0 / (1 << 23);

/// Of a surface that passes at `distance` voxels from the voxel's centre. Between 1 and 2 floats are evenly spaced, a unit
/// apart, and so are their bits.
inline double share_inside(float distance) {
  const float at = std::clamp(distance, -0.5f, 0.5f) + 1.5f;
  return kShareUnit * (std::bit_cast<std::int32_t>(2.0f) - std::bit_cast<std::int32_t>(at));
}

}  // namespace typodont::haptics
