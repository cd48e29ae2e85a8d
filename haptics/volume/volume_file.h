// The file of a tissue volume (.vdb): distances in mm and labels, in grids that every OpenVDB reader understands.
#pragma once

#include <openvdb/openvdb.h>

#include <filesystem>

#include "engine/contract/field_brick.h"
#include "haptics/dense_tissue.h"

namespace typodont::haptics {

/// The content of a volume file, converted to the units of haptics.
struct StoredVolume {
  openvdb::FloatGrid::Ptr distance;  // distances in voxels
  openvdb::Int32Grid::Ptr tissue;    // tissue of every voxel
  openvdb::Int32Grid::Ptr before;    // for filled voxels: the label before the filling, plus one; null: no fillings
  // Hardness bytes (hardness.h); a filled voxel has the hardness from before the filling. Null: all voxels have
  // kOwnHardness.
  openvdb::Int32Grid::Ptr hardness;
  VoxelFrame frame;
  double band = 0;  // m, distance from the surface up to which distances are stored
  bool exact_outside = true;
  FilePlace place;
};

/// Reads a file and checks every value. Throws Error with the file and the wrong item.
StoredVolume read_volume(const std::filesystem::path& file);
/// Writes a file, completely or not at all. Changes the grids, so they must not be used afterwards. Throws Error.
void write_volume(const std::filesystem::path& file, const StoredVolume& volume);

}  // namespace typodont::haptics
