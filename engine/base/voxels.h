// Loops over the voxels of a grid, and an order of voxels.
#pragma once

#include <glm/glm.hpp>
#include <tuple>

namespace typodont {

/// Calls visit(x, y, z) for all voxels from `lo` to `hi`, both included, z fastest.
template <class Visit>
void for_each_voxel_between(const glm::ivec3& lo, const glm::ivec3& hi, Visit&& visit) {
  for (int x = lo.x; x <= hi.x; ++x)
    for (int y = lo.y; y <= hi.y; ++y)
      for (int z = lo.z; z <= hi.z; ++z) visit(x, y, z);
}

/// Calls visit(x, y, z) for all voxels of a grid of `size`, z fastest.
template <class Visit>
void for_each_voxel(const glm::ivec3& size, Visit&& visit) {
  for_each_voxel_between(glm::ivec3(0), size - 1, visit);
}

/// Orders points or voxels by x, then y, then z.
struct LessByAxes {
  template <class V>
  bool operator()(const V& a, const V& b) const {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  }
};

}  // namespace typodont
