// Loops over the voxels of a grid.
#pragma once

#include <glm/glm.hpp>

namespace typodont {

/// Calls visit(x, y, z) for all voxels of a grid of `size`, z fastest.
template <class Visit>
void for_each_voxel(const glm::ivec3& size, Visit&& visit) {
  for (int x = 0; x < size.x; ++x)
    for (int y = 0; y < size.y; ++y)
      for (int z = 0; z < size.z; ++z) visit(x, y, z);
}

}  // namespace typodont
