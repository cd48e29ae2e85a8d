// Stores which samples of a volume were inside tissue before the first cut. With these data, the renderer distinguishes
// cut surfaces from natural ones, because cut enamel and dentin look different from natural surfaces.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/tissue_volume.h"

namespace typodont::haptics {

/// The natural surface of a volume. Immutable, so all copies of the volume share one object. Thread-safe.
class NaturalSurface {
 public:
  /// Reads all samples of the volume, in about 1 ms for a tooth.
  explicit NaturalSurface(const TissueVolume& volume);
  /// Returns 1 inside the tissue, 0 outside, and about ½ at its surface: a trilinear interpolation of the eight samples
  /// around the point.
  double inside(const glm::dvec3& p_W) const;

 private:
  bool solid(const glm::ivec3& voxel) const;

  VoxelFrame frame_;
  // first block and number of blocks (of 8³ samples) of the range that contains all tissue
  glm::ivec3 first_{0}, count_{0};
  std::vector<std::int32_t> block_;  // for each block: kEmpty, kFull, or the index of its samples in mixed_
  std::vector<SolidBits> mixed_;
};

}  // namespace typodont::haptics
