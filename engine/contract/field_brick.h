// A block of the distance field that the carver sends from its sparse volume to the surface mesher.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>

#include "engine/contract/tissue.h"

namespace typodont {

/// A brick: 16³ cells of the distance field, with one more layer of samples around them. Cell (i,j,k) of the brick
/// `key` has its corners at the voxels 16·key + (i,j,k) and 16·key + (i+1,j+1,k+1). Sample (x,y,z) of the arrays (each
/// index 0..18) is the voxel 16·key − 1 + (x,y,z); x is the slowest index.
struct FieldBrick {
  static constexpr int kCells = 16;
  static constexpr int kSamples = kCells + 3;
  static constexpr std::size_t kCount = std::size_t{kSamples} * kSamples * kSamples;

  static constexpr std::size_t at(int x, int y, int z) {
    return (static_cast<std::size_t>(x) * kSamples + static_cast<std::size_t>(y)) * kSamples +
           static_cast<std::size_t>(z);
  }

  glm::ivec3 key{0};
  /// voxels, signed distance to the surface, negative inside the tissue; absolute values are limited to the largest
  /// distance that the volume stores (the band)
  std::array<float, kCount> distance;
  // label of each sample; kAir far from all tissue, and in the whole brick if it contains no surface
  std::array<Tissue, kCount> tissue;
};

/// Position of the voxel grid in frame W: p_W = origin + voxel · index. The distance field and the tissue labels have
/// the same grid.
struct VoxelFrame {
  glm::dvec3 origin{0, 0, 0};  // m, position of voxel (0,0,0) in frame W
  double voxel = 1e-4;         // m, edge of a voxel

  glm::dvec3 to_world(const glm::dvec3& index) const { return origin + voxel * index; }
  glm::dvec3 to_voxels(const glm::dvec3& p_W) const { return (p_W - origin) / voxel; }
};

}  // namespace typodont
