// Volume files (.vdb): distances in mm and labels, readable by every program with OpenVDB.
#pragma once

#include <filesystem>

#include "engine/contract/field_brick.h"
#include "haptics/dense_tissue.h"
#include "haptics/volume/openvdb.h"

namespace typodont::haptics {

inline constexpr std::int32_t kNoFileColor = -1;  // in files: the voxel has the colour of its tissue

/// Content of a volume file in the units of haptics.
struct StoredVolume {
  openvdb::FloatGrid::Ptr distance;  // distances in voxels
  openvdb::Int32Grid::Ptr tissue;    // tissue of every voxel
  openvdb::Int32Grid::Ptr before;    // at filled voxels: 1 + label before the filling; null: no fillings
  // Hardness (dense_tissue.h); at filled voxels, the value before filling. Null: every voxel has kOwnHardness.
  openvdb::Int32Grid::Ptr hardness;
  // Colour, sRGB, 0xRRGGBB, or kNoFileColor; at filled voxels, the value before filling. Null: kNoFileColor everywhere.
  openvdb::Int32Grid::Ptr color;
  VoxelFrame frame;
  double band = 0;  // m, largest distance from the surface that is stored
  bool exact_outside = true;
  FilePlace place;
};

/// Reads a file and checks every value. Throws Error with the file and the item.
StoredVolume read_volume(const std::filesystem::path& file);
/// Writes the file completely or not at all. The grids cannot be used afterwards. Throws Error.
void write_volume(const std::filesystem::path& file, const StoredVolume& volume);

}  // namespace typodont::haptics
