// The key of a leaf, a block of 8³ samples of the tissue. Does not include OpenVDB. Private to haptics.
#pragma once

#include <glm/glm.hpp>

namespace typodont::haptics {

inline constexpr int kLeafSide = 8;  // samples

/// Returns the position, in units of leaves, of the leaf that contains the voxel.
inline glm::ivec3 leaf_key(const glm::ivec3& voxel) {
  static_assert(kLeafSide == 8);
  return {voxel.x >> 3, voxel.y >> 3, voxel.z >> 3};  // a shift rounds down, also for negative numbers
}

}  // namespace typodont::haptics
