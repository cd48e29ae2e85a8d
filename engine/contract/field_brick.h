// A block of samples of the distance field, from the carver's volume to the surface mesher.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"

namespace typodont {

/// 16³ cells and one more layer of samples around them. Cell (i,j,k) of brick `key` is between the voxels 16·key +
/// (i,j,k) and 16·key + (i+1,j+1,k+1). Sample (x,y,z), 0 to 18 each, is voxel 16·key − 1 + (x,y,z); x changes slowest.
struct FieldBrick {
  static constexpr int kCells = 16;
  static constexpr int kSamples = kCells + 3;
  static constexpr std::size_t kCount = std::size_t{kSamples} * kSamples * kSamples;

  static constexpr std::size_t at(int x, int y, int z) {
    return (static_cast<std::size_t>(x) * kSamples + static_cast<std::size_t>(y)) * kSamples +
           static_cast<std::size_t>(z);
  }

  glm::ivec3 key{0};
  /// Signed distance in voxels, negative inside the tissue, limited to the largest distance that the volume stores.
  std::array<float, kCount> distance;
  // Tissue of each sample; kAir far from all tissue, and in a brick without a surface.
  std::array<Tissue, kCount> tissue;
  bool colored = false;  // false: all samples have the colour of their tissue, and `color` is not set
  std::array<VoxelColor, kCount> color;
};

/// Position of the voxels: p_W = origin + voxel · index. Distances and tissue labels share this grid.
struct VoxelFrame {
  glm::dvec3 origin{0, 0, 0};  // m, position of voxel (0,0,0) in frame W
  double voxel = 1e-4;         // m, edge of a voxel

  glm::dvec3 to_world(const glm::dvec3& index) const { return origin + voxel * index; }
  glm::dvec3 to_voxels(const glm::dvec3& p_W) const { return (p_W - origin) / voxel; }
};

}  // namespace typodont
