// Fraction of a voxel inside a surface, in integer units, whose sums are exact in any order: removed, added and
// remaining volumes agree.
#pragma once

#include <bit>
#include <cstdint>

namespace typodont::haptics {

inline constexpr double kFractionUnit = 1.0 / (1 << 23);

/// In units, at `distance` voxels from the centre. Floats between 1 and 2 are a unit apart, so their bit patterns
/// subtract to units.
inline std::int32_t inside_units(float distance) {
  // No branch, to vectorise the sum over a leaf's 512 samples.
  const float above = distance < -0.5f ? -0.5f : distance;
  const float at = (above > 0.5f ? 0.5f : above) + 1.5f;
  return std::bit_cast<std::int32_t>(2.0f) - std::bit_cast<std::int32_t>(at);
}
inline double fraction_inside(float distance) {
  return kFractionUnit * inside_units(distance);
}

}  // namespace typodont::haptics
