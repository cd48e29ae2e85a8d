// Hardness of a voxel: how hard the tissue is there, as a fraction of the tissue's own hardness. One byte beside the
// label, so that caries can be soft at the surface and firm at its floor, or bone follow a scan's grey values.
//
// The law, valid everywhere in the program: at a voxel of tissue T with hardness byte b
//   stiffness felt          = stiffness of T · b / 255          (Material::stiffness)
//   specific cutting energy = specific energy of T · b / 255    (Material::specific_energy)
// Friction, density and colour do not depend on it. b = 255 is the tissue's own hardness, and is what every voxel has
// where nothing else was said. The least byte is 1: nothing is cut for free. A filling has hardness 255; a voxel keeps
// the byte of what was there before beside it, and has it again once the filling is cut out (see label.h).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace typodont::haptics {

inline constexpr std::uint8_t kOwnHardness = 255;
inline constexpr std::uint8_t kLeastHardness = 1;

/// The byte nearest to a fraction 0..1; at least kLeastHardness.
inline std::uint8_t hardness_byte(double fraction) {
  const double byte = std::round(std::clamp(fraction, 0.0, 1.0) * kOwnHardness);
  return std::max(kLeastHardness, static_cast<std::uint8_t>(byte));
}
inline double hardness_fraction(std::uint8_t byte) noexcept {
  return byte * (1.0 / kOwnHardness);
}

}  // namespace typodont::haptics
