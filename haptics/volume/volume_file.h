// Volume files (.vdb): distances in mm and labels, readable by every program with OpenVDB.
#pragma once

#include <filesystem>
#include <optional>

#include "engine/contract/field_brick.h"
#include "haptics/dense_tissue.h"
#include "haptics/volume/block_grid.h"

namespace typodont::haptics {

inline constexpr std::int32_t kNoFileColor = -1;  // in files: the voxel has the colour of its tissue

/// Content of a volume file in the units of haptics.
struct StoredVolume {
  DistanceGrid distance;            // voxels
  LabelGrid tissue;                 // tissue of every voxel
  std::optional<LabelGrid> before;  // at filled voxels: 1 + label before the filling
  // Hardness (dense_tissue.h); at filled voxels, the value before filling. nullopt: every voxel has kOwnHardness.
  std::optional<LabelGrid> hardness;
  // Colour, sRGB, 0xRRGGBB, or kNoFileColor; at filled voxels, the value before filling. nullopt: kNoFileColor
  // everywhere.
  std::optional<LabelGrid> color;
  VoxelFrame frame;
  double band = 0;  // m, largest distance from the surface that is stored
  bool exact_outside = true;
  FilePlace place;
};

/// Reads a file and checks every value. Throws Error with the file and the item.
StoredVolume read_volume(const std::filesystem::path& file);
/// Writes the file completely or not at all. Throws Error.
void write_volume(const std::filesystem::path& file, StoredVolume volume);

}  // namespace typodont::haptics
