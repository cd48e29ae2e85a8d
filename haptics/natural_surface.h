// The tissue before the first cut: which samples of a volume lay in tissue. A picture uses it to tell a cut surface
// from a natural one, because cut enamel and cut dentin look different from a crown and a root.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/tissue_volume.h"

namespace typodont::haptics {

/// Immutable, so that all copies of a volume can share it. Thread-safe.
class NaturalSurface {
 public:
  /// Reads all samples of the volume. Takes about 1 ms for a tooth.
  explicit NaturalSurface(const TissueVolume& volume);
  /// 1 inside the tissue, 0 outside, about ½ at its surface: the eight samples around the point, weighted trilinearly.
  double inside(const glm::dvec3& p_W) const;

 private:
  bool solid(const glm::ivec3& voxel) const;

  VoxelFrame frame_;
  glm::ivec3 first_{0}, count_{0};   // the range of blocks of 8³ samples that contain all tissue
  std::vector<std::int32_t> block_;  // for each block: kEmpty, kFull, or an index into mixed_
  std::vector<SolidBits> mixed_;
};

}  // namespace typodont::haptics
