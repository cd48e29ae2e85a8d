// Converts a volume to plain arrays and back. Used at set-up time to change a whole volume.
#pragma once

#include <vector>

#include "engine/session/dense_field.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// A copy of the samples in a box of a volume. The origin of `frame` is the first sample of the box.
struct DenseCopy {
  VoxelFrame frame;
  session::DenseField field;
  std::vector<Tissue> tissue;
  /// hardness of each sample (see haptics/hardness.h); empty if all tissue has its own hardness
  std::vector<std::uint8_t> hardness;
};

/// Copies the samples in a box: the given box of voxels, or the bounds of the volume with two voxels around them.
DenseCopy dense_copy(const haptics::TissueVolume& volume);
DenseCopy dense_copy(const haptics::TissueVolume& volume, const glm::ivec3& lo, const glm::ivec3& size);

/// Makes a volume from the copy. `band`: m, see TissueVolume::band(). Distances outside the tissue are treated as
/// inexact.
haptics::TissueVolume from_dense(const DenseCopy& copy, double band);

/// Removes the tissue inside the solid. The labels do not change.
haptics::TissueVolume without_solid(const haptics::TissueVolume& volume, const haptics::Solid& solid);

}  // namespace typodont
