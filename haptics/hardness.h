// Hardness of a voxel: a fraction of the stiffness and specific cutting energy that the voxel's tissue normally has.
// Each voxel has one byte of hardness. So caries can be soft at its surface and firm at its floor, and bone can follow
// the grey values of a scan.
//
// The same law is used in the whole program. For a voxel of tissue T with the hardness byte b:
//   stiffness               = stiffness of T · b / 255          (Material::stiffness)
//   specific cutting energy = specific energy of T · b / 255    (Material::specific_energy)
// Friction, density and colour do not depend on hardness. b = 255 is the tissue's full hardness, and the default of
// every voxel. The smallest byte is 1, so cutting always needs energy. A filling has hardness 255. A filled voxel also
// keeps its former byte, which becomes valid again when the filling is cut out (see label.h).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace typodont::haptics {

inline constexpr std::uint8_t kOwnHardness = 255;
inline constexpr std::uint8_t kLeastHardness = 1;

/// Converts a hardness fraction 0..1 to a byte by rounding; the result is at least kLeastHardness.
inline std::uint8_t hardness_byte(double fraction) {
  const double byte = std::round(std::clamp(fraction, 0.0, 1.0) * kOwnHardness);
  return std::max(kLeastHardness, static_cast<std::uint8_t>(byte));
}
inline double hardness_fraction(std::uint8_t byte) noexcept {
  return byte * (1.0 / kOwnHardness);
}

}  // namespace typodont::haptics
