// Tissue as plain arrays, and a box of voxels. Independent of OpenVDB, of file formats and of other headers of haptics.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"

namespace typodont::haptics {

/// Voxels lo .. hi, inclusive; empty if lo > hi.
struct VoxelBox {
  glm::ivec3 lo{1}, hi{0};
  bool empty() const { return lo.x > hi.x; }
};
/// The voxels that lie in both boxes.
inline VoxelBox common(const VoxelBox& a, const VoxelBox& b) {
  const VoxelBox box{glm::max(a.lo, b.lo), glm::min(a.hi, b.hi)};
  return glm::all(glm::lessThanEqual(box.lo, box.hi)) ? box : VoxelBox{};
}

/// A box of tissue as plain arrays, made by importers and analytic solids. z runs fastest: index (x·size.y + y)·size.z
/// + z.
struct DenseTissue {
  VoxelFrame frame;  // voxel (0,0,0) of the arrays is at frame.origin
  glm::ivec3 size{0};
  std::vector<float> distance;  // m, negative inside; the true distance wherever |distance| < band
  // Tissue of every voxel. At least one voxel outside the surface has the nearest tissue as well, so that labels can be
  // read at the surface; kAir elsewhere.
  std::vector<Tissue> tissue;
  std::vector<std::uint8_t> hardness;  // hardness of every voxel, see hardness.h; empty: kOwnHardness everywhere
  double band = 1.5e-3;                // m, limit of the stored distances
  bool exact_outside = true;           // outside the tissue, the distance never exceeds the true one

  std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(x) * size.y + static_cast<std::size_t>(y)) * size.z + static_cast<std::size_t>(z);
  }
};

}  // namespace typodont::haptics
