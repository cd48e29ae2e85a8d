// Volumes as plain arrays, to change or compare them whole. Not for the servo thread.
#pragma once

#include <string>
#include <vector>

#include "engine/session/dense_field.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Samples of a box; `frame` begins at its first sample.
struct DenseCopy {
  VoxelFrame frame;
  session::DenseField field;
  std::vector<Tissue> tissue;
  /// 255: full; empty: full everywhere
  std::vector<std::uint8_t> hardness;
  haptics::FilePlace place;
};

/// The given box, or the volume's bounds and two voxels.
DenseCopy dense_copy(const haptics::TissueVolume& volume);
DenseCopy dense_copy(const haptics::TissueVolume& volume, const glm::ivec3& lo, const glm::ivec3& size);

/// All tissue, distances in m. Throws Error with `file` if there is none.
haptics::DenseTissue dense_tissue(const haptics::TissueVolume& volume, const std::string& file);

/// `band`: m, largest stored distance. Distances outside the tissue count as inexact.
haptics::TissueVolume from_dense(const DenseCopy& copy, double band);

/// Labels stay.
haptics::TissueVolume without_solid(const haptics::TissueVolume& volume, const haptics::Solid& solid);

}  // namespace typodont
