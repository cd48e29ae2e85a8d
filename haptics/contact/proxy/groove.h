// Computes grooves and inner corners that are sharper than the samples can represent, from the flat walls that meet
// there.
#pragma once

#include "haptics/contact/tissue_patch.h"

namespace typodont::haptics {

/// The flat walls of a groove or inner corner. Each wall has a unit normal. `height`: distance of each wall, in voxels,
/// from the point for which the walls were searched.
struct FlatWalls {
  static constexpr int kMost = 3;
  int count = 0;
  dvec3 n[kMost];
  double height[kMost];
};

/// Finds the flat walls of a concave crease or corner. (Interpolation shows tissue at its bottom.) `at`: value and
/// gradient of the field at the point `c`. Returns false if there are no such walls, or if another surface is nearer.
bool walls_of_crease(const TissuePatch& patch, const dvec3& c, const FieldSample& at, FlatWalls& walls) noexcept;

}  // namespace typodont::haptics
