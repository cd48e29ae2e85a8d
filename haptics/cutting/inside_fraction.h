// Fraction of a voxel that lies inside a surface, as an integer, so that sums are exact in any order. So removed, added
// and remaining volumes agree.
#pragma once

#include <bit>
#include <cstdint>

namespace typodont::haptics {

inline constexpr double kFractionUnit = 1.0 / (1 << 23);

/// Returns the fraction in units of 2⁻²³, if the surface is `distance` voxels from the voxel's centre. Floats between 1
/// and 2 are one unit apart, so the difference of their bit patterns is a number of units.
inline std::int32_t inside_units(float distance) {
  // Without branches, so that the sum over the 512 samples of a leaf is vectorised.
  const float above = distance < -0.5f ? -0.5f : distance;
  const float at = (above > 0.5f ? 0.5f : above) + 1.5f;
  return std::bit_cast<std::int32_t>(2.0f) - std::bit_cast<std::int32_t>(at);
}
inline double fraction_inside(float distance) {
  return kFractionUnit * inside_units(distance);
}

}  // namespace typodont::haptics
