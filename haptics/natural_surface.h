// What was inside tissue before the first cut: cut enamel and dentin look different.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/tissue_volume.h"

namespace typodont::haptics {

/// Immutable, so a volume's copies share it. Thread-safe.
class NaturalSurface {
 public:
  /// About 1 ms for a tooth.
  explicit NaturalSurface(const TissueVolume& volume);
  /// Before the first cut: 1 inside, 0 outside, about ½ at the surface; trilinear.
  double inside(const glm::dvec3& p_W) const;

 private:
  bool solid(const glm::ivec3& voxel) const;

  VoxelFrame frame_;
  // Of 8³ samples; from first_, count_ along each axis, all that hold tissue.
  glm::ivec3 first_{0}, count_{0};
  std::vector<std::int32_t> block_;  // kEmpty, kFull, or index in mixed_
  std::vector<SolidBits> mixed_;
};

}  // namespace typodont::haptics
