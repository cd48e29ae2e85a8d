// Converts tissue to plain arrays and back, for changes of a whole volume at set-up time.
#pragma once

#include <vector>

#include "engine/session/dense_field.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// A copy of a box of a volume's samples. The origin of `frame` is the first sample of the box.
struct DenseCopy {
  VoxelFrame frame;
  session::DenseField field;
  std::vector<Tissue> tissue;
  std::vector<std::uint8_t> hardness;  // see haptics/hardness.h; empty if all tissue has its own hardness
};

/// Copies a box of the volume: its bounds with two voxels around them, or the given box of its voxels.
DenseCopy dense_copy(const haptics::TissueVolume& volume);
DenseCopy dense_copy(const haptics::TissueVolume& volume, const glm::ivec3& lo, const glm::ivec3& size);

/// Makes a volume. `band`: m, see TissueVolume::band(). Distances outside the tissue are treated as inexact.
haptics::TissueVolume from_dense(const DenseCopy& copy, double band);

/// Removes the inside of the solid; the labels do not change.
haptics::TissueVolume without_solid(const haptics::TissueVolume& volume, const haptics::Solid& solid);

}  // namespace typodont
