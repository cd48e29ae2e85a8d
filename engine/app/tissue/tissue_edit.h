// Converts a volume to plain arrays and back. Used to change or compare whole volumes. Not for the servo thread.
#pragma once

#include <string>
#include <vector>

#include "engine/session/dense_field.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// A copy of the samples in a box of a volume. The origin of `frame` is the first sample of the box.
struct DenseCopy {
  VoxelFrame frame;
  session::DenseField field;
  std::vector<Tissue> tissue;
  /// hardness of each sample, 255: the tissue's full hardness; empty if all samples have the full hardness
  std::vector<std::uint8_t> hardness;
  haptics::FilePlace place;
};

/// Copies the samples in a box: the given box of voxels, or the bounds of the volume with two voxels around them.
DenseCopy dense_copy(const haptics::TissueVolume& volume);
DenseCopy dense_copy(const haptics::TissueVolume& volume, const glm::ivec3& lo, const glm::ivec3& size);

/// Copies all tissue of a volume, with distances in m. Throws Error with the name `file` if there is no tissue.
haptics::DenseTissue dense_tissue(const haptics::TissueVolume& volume, const std::string& file);

/// Makes a volume from the copy. `band`: m, the largest distance that the volume stores. The volume treats its
/// distances outside the tissue as inexact.
haptics::TissueVolume from_dense(const DenseCopy& copy, double band);

/// Removes the tissue inside the solid. The labels do not change.
haptics::TissueVolume without_solid(const haptics::TissueVolume& volume, const haptics::Solid& solid);

}  // namespace typodont
