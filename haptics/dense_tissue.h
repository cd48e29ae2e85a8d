// Dense arrays of tissue, and boxes of voxels. Independent of OpenVDB, file formats and other headers of haptics.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string_view>
#include <vector>

#include "engine/base/pose.h"
#include "engine/base/voxels.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"

namespace typodont::haptics {

/// Box of voxels from lo to hi, both inclusive; empty if lo > hi.
struct VoxelBox {
  glm::ivec3 lo{1}, hi{0};
  bool empty() const { return lo.x > hi.x; }
};
/// Intersection of two boxes.
inline VoxelBox common(const VoxelBox& a, const VoxelBox& b) {
  const VoxelBox box{glm::max(a.lo, b.lo), glm::min(a.hi, b.hi)};
  return glm::all(glm::lessThanEqual(box.lo, box.hi)) ? box : VoxelBox{};
}

/// Extends a box; `other` must not be empty.
inline void extend(VoxelBox& box, const VoxelBox& other) noexcept {
  box = box.empty() ? other : VoxelBox{glm::min(box.lo, other.lo), glm::max(box.hi, other.hi)};
}

/// Anatomical directions of a file's axes.
enum class PatientAxes : std::uint8_t {
  kUnknown,
  kLps,  // x, y, z point to the patient's left, back, head
  kRas   // x, y, z point to the patient's right, front, head
};
/// Returns "LPS", "RAS", or an empty string if unknown.
inline std::string_view name_of(PatientAxes axes) {
  return axes == PatientAxes::kLps ? "LPS" : axes == PatientAxes::kRas ? "RAS" : "";
}
/// Returns the axes of a name; kUnknown if unknown.
inline PatientAxes patient_axes(std::string_view name) {
  return name == "LPS" ? PatientAxes::kLps : name == "RAS" ? PatientAxes::kRas : PatientAxes::kUnknown;
}
/// Pose of imported tissue in its source file. If the tissue is moved, this pose changes too, so results can be written
/// in the file's coordinates.
struct FilePlace {
  Pose X_FW;  // pose of the tissue's frame W in the file's frame F, m
  PatientAxes axes = PatientAxes::kUnknown;
};

/// Tissue as dense arrays, created by importers and solids.
struct DenseTissue {
  VoxelFrame frame;  // voxel (0,0,0) is at frame.origin
  glm::ivec3 size{0};
  std::vector<float> distance;  // m, signed distance of each voxel from the surface, negative inside; exact up to band
  // Outside the tissue: kAir, but voxels next to the surface have the label of the nearest tissue, so that
  // interpolation at the surface finds a tissue.
  std::vector<Tissue> tissue;
  // Hardness of each voxel; empty: all voxels have kOwnHardness.
  std::vector<std::uint8_t> hardness;
  std::vector<VoxelColor> color;  // empty: all voxels have kTissueColor
  double band = 1.5e-3;           // m, largest stored distance
  bool exact_outside = true;      // false: outside, the stored distance may be smaller than the true one, never larger
  FilePlace place;

  std::size_t at(int x, int y, int z) const { return voxel_index({x, y, z}, size); }
};

/// Hardness byte of a voxel with the full stiffness and specific energy of its Material. A byte b stands for the
/// fraction b / 255 of both. Smaller bytes: soft caries, and bone whose hardness follows from a scan's grey values.
inline constexpr std::uint8_t kOwnHardness = 255;
inline constexpr std::uint8_t kMinHardness = 1;

/// Returns the byte for a fraction 0..1, rounded, at least kMinHardness.
inline std::uint8_t hardness_byte(double fraction) {
  const double byte = std::round(std::clamp(fraction, 0.0, 1.0) * kOwnHardness);
  return std::max(kMinHardness, static_cast<std::uint8_t>(byte));
}
inline double hardness_fraction(std::uint8_t byte) noexcept {
  return byte * (1.0 / kOwnHardness);
}

}  // namespace typodont::haptics
