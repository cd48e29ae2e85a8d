// Stores which samples of a volume were inside tissue before the first cut. The surface before the first cut is called
// the natural surface. Cut enamel and dentin look different from it, so the renderer must know which surface was cut.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/tissue_volume.h"

namespace typodont::haptics {

/// The tissue of a volume as it was before the first cut. Immutable, so all copies of the volume share one object.
/// Thread-safe.
class NaturalSurface {
 public:
  /// Reads all samples of the volume, in about 1 ms for a tooth.
  explicit NaturalSurface(const TissueVolume& volume);
  /// Returns whether the point was inside the tissue before the first cut: 1 inside, 0 outside, about ½ at the surface.
  /// The value is a trilinear interpolation of the eight samples around the point.
  double inside(const glm::dvec3& p_W) const;

 private:
  bool solid(const glm::ivec3& voxel) const;

  VoxelFrame frame_;
  // Blocks have 8³ samples. Only the range of blocks that contains all tissue is stored: first_ is its first block,
  // count_ the number of its blocks along each axis.
  glm::ivec3 first_{0}, count_{0};
  std::vector<std::int32_t> block_;  // for each block: kEmpty, kFull, or the index of its samples in mixed_
  std::vector<SolidBits> mixed_;
};

}  // namespace typodont::haptics
