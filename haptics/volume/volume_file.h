// A tissue volume's file (.vdb): distances in mm and labels, in grids that any reader of OpenVDB understands.
#pragma once

#include <openvdb/openvdb.h>

#include <filesystem>

#include "engine/contract/field_brick.h"

namespace typodont::haptics {

/// What a file holds, in the haptics' units.
struct StoredVolume {
  openvdb::FloatGrid::Ptr distance;  // voxels
  openvdb::Int32Grid::Ptr tissue;    // what every voxel shows
  openvdb::Int32Grid::Ptr before;    // of filled voxels the label from before, plus one; nowhere: none
  openvdb::Int32Grid::Ptr hardness;  // bytes (hardness.h), of a filled voxel that from before; none: all kOwnHardness
  VoxelFrame frame;
  double band = 0;  // m
  bool exact_outside = true;
};

/// Throws Error naming the file and what in it is wrong: every value is checked.
StoredVolume read_volume(const std::filesystem::path& file);
/// Takes the grids over. The file is there whole or not at all; throws Error.
void write_volume(const std::filesystem::path& file, const StoredVolume& volume);

}  // namespace typodont::haptics
