// Arrays of tissue and boxes of voxels, without OpenVDB, file formats or other headers of haptics.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string_view>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"

namespace typodont::haptics {

/// lo to hi, inclusive; empty if lo > hi.
struct VoxelBox {
  glm::ivec3 lo{1}, hi{0};
  bool empty() const { return lo.x > hi.x; }
};
/// What is in both.
inline VoxelBox common(const VoxelBox& a, const VoxelBox& b) {
  const VoxelBox box{glm::max(a.lo, b.lo), glm::min(a.hi, b.hi)};
  return glm::all(glm::lessThanEqual(box.lo, box.hi)) ? box : VoxelBox{};
}

/// Axes of a file, relative to the patient.
enum class PatientAxes : std::uint8_t {
  kUnknown,
  kLps,  // to the patient's left, back, head
  kRas   // to the patient's right, front, head
};
/// "LPS", "RAS", or empty.
inline std::string_view name_of(PatientAxes axes) {
  return axes == PatientAxes::kLps ? "LPS" : axes == PatientAxes::kRas ? "RAS" : "";
}
/// Other names: kUnknown.
inline PatientAxes patient_axes(std::string_view name) {
  return name == "LPS" ? PatientAxes::kLps : name == "RAS" ? PatientAxes::kRas : PatientAxes::kUnknown;
}
/// Where imported tissue is in its file; turns and moves with it, so results can go back to the file's coordinates.
struct FilePlace {
  Pose X_FW;  // tissue's frame to file, m
  PatientAxes axes = PatientAxes::kUnknown;
};

/// By importers and solids. z fastest: (x·size.y + y)·size.z + z.
struct DenseTissue {
  VoxelFrame frame;  // voxel (0,0,0) is at frame.origin
  glm::ivec3 size{0};
  std::vector<float> distance;  // m, negative inside; exact where |distance| < band
  // Outside: kAir, but at least one voxel around has the nearest tissue, so that labels can be read at the surface.
  std::vector<Tissue> tissue;
  // Empty: kOwnHardness everywhere
  std::vector<std::uint8_t> hardness;
  double band = 1.5e-3;       // m, largest distance that is stored
  bool exact_outside = true;  // outside, never more than the true distance
  FilePlace place;

  std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(x) * size.y + static_cast<std::size_t>(y)) * size.z + static_cast<std::size_t>(z);
  }
};

/// Hardness, one byte per voxel: fraction of a tissue's stiffness and specific cutting energy (caries soft on top and
/// firm below, bone by the grey values of a scan). Everywhere, for tissue T with hardness byte b:
///   stiffness               = stiffness of T · b / 255          (Material::stiffness)
///   specific cutting energy = specific energy of T · b / 255    (Material::specific_energy)
/// Not for friction, density and colour. 255, the default, is full hardness; the least is 1, so cutting takes energy.
/// Filling has 255; the voxel keeps its former byte for when it is cut out (volume/label.h).
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
