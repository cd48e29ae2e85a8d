// The tissue before the first cut. The renderer needs it because cut enamel and dentin look different from natural
// surfaces.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/tissue_volume.h"

namespace typodont::haptics {

/// Immutable and shared by copies of a volume. Any thread.
class NaturalSurface {
 public:
  /// Stores the current tissue of `volume`; takes about 1 ms for a tooth.
  explicit NaturalSurface(const TissueVolume& volume);
  /// Returns whether a point was inside tissue before the first cut: 1 inside, 0 outside, about ½ at the surface;
  /// trilinear interpolation.
  double inside(const glm::dvec3& p_W) const;

 private:
  bool solid(const glm::ivec3& voxel) const;

  VoxelFrame frame_;
  // Box of all blocks of 8³ samples that contain tissue: first_ is the first block, count_ the number along each axis.
  glm::ivec3 first_{0}, count_{0};
  std::vector<std::int32_t> block_;  // for each block: kEmpty, kFull, or its index in mixed_
  std::vector<SolidBits> mixed_;
};

}  // namespace typodont::haptics
