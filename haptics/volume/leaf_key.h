// Key of a block of 8³ samples. Private to haptics.
#pragma once

#include <glm/glm.hpp>

namespace typodont::haptics {

inline constexpr int kLeafSide = 8;  // samples along an edge of a leaf

/// Position, in leaves, of the leaf that contains a voxel.
inline glm::ivec3 leaf_key(const glm::ivec3& voxel) {
  static_assert(kLeafSide == 8);
  return {voxel.x >> 3, voxel.y >> 3, voxel.z >> 3};  // a shift rounds down, also for negative numbers
}

}  // namespace typodont::haptics
