// Fraction of a tissue's stiffness and specific cutting energy, one byte per voxel: caries soft on top and firm below,
// bone by the grey values of a scan.
//
// Everywhere, for tissue T with hardness byte b:
//   stiffness               = stiffness of T · b / 255          (Material::stiffness)
//   specific cutting energy = specific energy of T · b / 255    (Material::specific_energy)
// Not for friction, density and colour. 255, the default, is full hardness; the least is 1, so cutting takes energy.
// Filling has 255; the voxel keeps its former byte for when it is cut out (label.h).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace typodont::haptics {

inline constexpr std::uint8_t kOwnHardness = 255;
inline constexpr std::uint8_t kLeastHardness = 1;

/// From 0..1, rounded, at least kLeastHardness.
inline std::uint8_t hardness_byte(double fraction) {
  const double byte = std::round(std::clamp(fraction, 0.0, 1.0) * kOwnHardness);
  return std::max(kLeastHardness, static_cast<std::uint8_t>(byte));
}
inline double hardness_fraction(std::uint8_t byte) noexcept {
  return byte * (1.0 / kOwnHardness);
}

}  // namespace typodont::haptics
