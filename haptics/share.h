// The share of a voxel that lies inside a surface, as all of the haptics count it: in whole units, so that volumes are
// exact sums, whatever their order, and what is taken, put down and left over adds up to the last unit.
#pragma once

#include <bit>
#include <cstdint>

namespace typodont::haptics {

inline constexpr double kShareUnit = 1.0 / (1 << 23);

/// Of a surface that passes at `distance` voxels from the voxel's centre, in units. Between 1 and 2 floats are evenly
/// spaced, a unit apart, and so are their bits.
inline std::int32_t units_inside(float distance) {
  const float above = distance < -0.5f ? -0.5f : distance;  // without a branch: whole leaves are summed up in one go
  const float at = (above > 0.5f ? 0.5f : above) + 1.5f;
  return std::bit_cast<std::int32_t>(2.0f) - std::bit_cast<std::int32_t>(at);
}
inline double share_inside(float distance) {
  return kShareUnit * units_inside(distance);
}

}  // namespace typodont::haptics
