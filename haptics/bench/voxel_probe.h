// A peer's method as a baseline: contact with voxels that are full or empty.
#pragma once

#include <vector>

#include "haptics/solid.h"

namespace typodont::haptics::bench {

/// Voxel probing as in CHAI3D's volume objects with a finger proxy (Ruspini 1997): a voxel is full or empty, the proxy
/// marches in half voxels until the head meets a full one, the normal is where the empty space around it lies, and the
/// rest of the way goes along the plane.
class VoxelProbe {
 public:
  VoxelProbe(const DenseTissue& dense, double radius, const dvec3& start);

  /// Direction in which the hand at p_WT is pushed; 0 when it is free.
  dvec3 push(const dvec3& p_WT);

 private:
  /// Whether the head at `c` (voxels) meets a full voxel, and if `n` is asked for which way out.
  bool probe(const dvec3& c, double radius, dvec3* n) const;
  /// Half voxels toward `aim` until the head meets tissue; true when it did.
  bool march(const dvec3& aim);

  VoxelFrame frame_;
  glm::ivec3 size_;
  double radius_;
  dvec3 c_;
  std::vector<char> full_;
};

}  // namespace typodont::haptics::bench
