// Copies of volumes as plain arrays, to change or compare whole volumes. Not for the servo thread.
#pragma once

#include <string>
#include <vector>

#include "engine/session/dense_field.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Samples of a box; `frame` originates at the first sample.
struct DenseCopy {
  VoxelFrame frame;
  session::DenseField field;
  std::vector<Tissue> tissue;
  /// Hardness of each sample; 255: full. Empty: full everywhere.
  std::vector<std::uint8_t> hardness;
  std::vector<VoxelColor> color;  // empty: kTissueColor everywhere
  haptics::FilePlace place;
};

/// Copies the box of `size` samples from `lo` on; without these: the volume's bounding box and 2 voxels around it.
DenseCopy dense_copy(const haptics::TissueVolume& volume);
DenseCopy dense_copy(const haptics::TissueVolume& volume, const glm::ivec3& lo, const glm::ivec3& size);

/// Copies all tissue, with distances in m. `file`: name for messages. Throws Error if the volume contains no tissue.
haptics::DenseTissue dense_tissue(const haptics::TissueVolume& volume, const std::string& file);

/// Makes a volume. `band`: largest stored distance, m. Outside the tissue, stored distances may be smaller than the
/// true ones.
haptics::TissueVolume from_dense(const DenseCopy& copy, double band);

/// Distance to the surface of the region with the wanted labels. Smooth, because it uses the fraction of such voxels
/// among 3×3×3.
session::DenseField label_distance(const DenseCopy& copy, const std::vector<Tissue>& wanted);

/// Removes a solid's inside. Labels do not change.
haptics::TissueVolume without_solid(const haptics::TissueVolume& volume, const haptics::Solid& solid);
/// Adds a bounded solid. The tissue inside it does not change; the rest of the solid gets the label `tissue`.
haptics::TissueVolume with_solid(const haptics::TissueVolume& volume, const haptics::Solid& solid, Tissue tissue);

}  // namespace typodont
