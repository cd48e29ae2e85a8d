// Tissue as plain arrays, and boxes of voxels. Independent of OpenVDB, of file formats and of other headers in haptics.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string_view>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"

namespace typodont::haptics {

/// A box of voxels from lo to hi, inclusive; empty if lo > hi.
struct VoxelBox {
  glm::ivec3 lo{1}, hi{0};
  bool empty() const { return lo.x > hi.x; }
};
/// Returns the box of the voxels that are in both boxes.
inline VoxelBox common(const VoxelBox& a, const VoxelBox& b) {
  const VoxelBox box{glm::max(a.lo, b.lo), glm::min(a.hi, b.hi)};
  return glm::all(glm::lessThanEqual(box.lo, box.hi)) ? box : VoxelBox{};
}

/// Directions of the axes of a file's coordinates, relative to the patient.
enum class PatientAxes : std::uint8_t {
  kUnknown,
  kLps,  // x to the patient's left, y to the back, z to the head
  kRas   // x to the patient's right, y to the front, z to the head
};
/// Returns "LPS" or "RAS", or an empty name for unknown axes.
inline std::string_view name_of(PatientAxes axes) {
  return axes == PatientAxes::kLps ? "LPS" : axes == PatientAxes::kRas ? "RAS" : "";
}
/// Returns the axes that name_of() names so, or kUnknown for any other name.
inline PatientAxes patient_axes(std::string_view name) {
  return name == "LPS" ? PatientAxes::kLps : name == "RAS" ? PatientAxes::kRas : PatientAxes::kUnknown;
}
/// The place of imported tissue in the file from which it was imported (a scan or a mesh). If tissue is turned or
/// moved after the import, the place changes with it, so that results can be written in the coordinates of the file.
struct FilePlace {
  Pose X_FW;  // converts a position in the tissue's frame to a position in the file, m
  PatientAxes axes = PatientAxes::kUnknown;
};

/// A box of tissue as plain arrays. Importers and analytic solids create it. z runs fastest: index (x·size.y +
/// y)·size.z + z.
struct DenseTissue {
  VoxelFrame frame;  // voxel (0,0,0) of the arrays is at the position frame.origin
  glm::ivec3 size{0};
  std::vector<float> distance;  // m, signed distance, negative inside; exact wherever |distance| < band
  // Tissue of every voxel. Voxels outside the surface are kAir, except a layer of at least one voxel around the tissue:
  // it has the label of the nearest tissue, so that labels can be read at the surface.
  std::vector<Tissue> tissue;
  // hardness of every voxel (hardness.h); if the array is empty, every voxel has kOwnHardness
  std::vector<std::uint8_t> hardness;
  double band = 1.5e-3;       // m, largest distance that is stored
  bool exact_outside = true;  // true: outside the tissue, the stored distance never exceeds the true distance
  FilePlace place;

  std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(x) * size.y + static_cast<std::size_t>(y)) * size.z + static_cast<std::size_t>(z);
  }
};

}  // namespace typodont::haptics
