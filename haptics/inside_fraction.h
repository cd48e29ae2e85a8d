// Computes the fraction of a voxel that lies inside a surface, for all of haptics. Fractions are integer numbers of
// small units. Sums of integers are exact in any order, so the removed, added and remaining volumes are consistent.
#pragma once

#include <bit>
#include <cstdint>

namespace typodont::haptics {

inline constexpr double kFractionUnit = 1.0 / (1 << 23);

/// Returns the fraction of a voxel that lies inside the surface, as a number of units, if the surface is `distance`
/// voxels away from the voxel's centre. Floats between 1 and 2 have equal spacing (one unit), so the difference of two
/// bit patterns is a number of units.
inline std::int32_t inside_units(float distance) {
  // There is no branch here, so that the compiler can vectorise the sum over the 512 samples of a leaf.
  const float above = distance < -0.5f ? -0.5f : distance;
  const float at = (above > 0.5f ? 0.5f : above) + 1.5f;
  return std::bit_cast<std::int32_t>(2.0f) - std::bit_cast<std::int32_t>(at);
}
inline double fraction_inside(float distance) {
  return kFractionUnit * inside_units(distance);
}

}  // namespace typodont::haptics
