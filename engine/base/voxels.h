// Indices of the voxels of a grid, loops over them, and their order. Arrays of voxels: z is the fastest index.
#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <tuple>
#include <type_traits>

namespace typodont {

/// Steps from a voxel to its six neighbours.
inline constexpr std::array<glm::ivec3, 6> kFaceSteps = {glm::ivec3(1, 0, 0), {-1, 0, 0}, {0, 1, 0},
                                                         {0, -1, 0},          {0, 0, 1},  {0, 0, -1}};

inline std::size_t voxel_count(const glm::ivec3& size) noexcept {
  return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z);
}
/// Index of a voxel in the array of a grid of `size`.
inline std::size_t voxel_index(const glm::ivec3& voxel, const glm::ivec3& size) noexcept {
  return (static_cast<std::size_t>(voxel.x) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(voxel.y)) *
             static_cast<std::size_t>(size.z) +
         static_cast<std::size_t>(voxel.z);
}
/// The voxel with this index.
inline glm::ivec3 voxel_at(std::size_t index, const glm::ivec3& size) noexcept {
  const auto nz = static_cast<std::size_t>(size.z), ny = static_cast<std::size_t>(size.y);
  return {static_cast<int>(index / (nz * ny)), static_cast<int>(index / nz % ny), static_cast<int>(index % nz)};
}
inline bool in_grid(const glm::ivec3& voxel, const glm::ivec3& size) noexcept {
  return voxel.x >= 0 && voxel.y >= 0 && voxel.z >= 0 && voxel.x < size.x && voxel.y < size.y && voxel.z < size.z;
}

/// Calls visit(x, y, z) or visit(voxel) for all voxels from `lo` to `hi`, both included, z fastest.
template <class Visit>
void for_each_voxel_between(const glm::ivec3& lo, const glm::ivec3& hi, Visit&& visit) {
  for (int x = lo.x; x <= hi.x; ++x)
    for (int y = lo.y; y <= hi.y; ++y)
      for (int z = lo.z; z <= hi.z; ++z) {
        if constexpr (std::is_invocable_v<Visit&, glm::ivec3>)
          visit(glm::ivec3(x, y, z));
        else
          visit(x, y, z);
      }
}

/// Calls visit(x, y, z) or visit(voxel) for all voxels of a grid of `size`, z fastest.
template <class Visit>
void for_each_voxel(const glm::ivec3& size, Visit&& visit) {
  for_each_voxel_between(glm::ivec3(0), size - 1, visit);
}

/// Hash of a voxel or of the key of a block, for unordered containers.
struct KeyHash {
  std::size_t operator()(const glm::ivec3& k) const noexcept {
    return static_cast<std::size_t>(k.x) * 73856093u ^ static_cast<std::size_t>(k.y) * 19349663u ^
           static_cast<std::size_t>(k.z) * 83492791u;
  }
};

/// Orders points or voxels by x, then y, then z.
struct LessByAxes {
  template <class V>
  bool operator()(const V& a, const V& b) const {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  }
};

}  // namespace typodont
