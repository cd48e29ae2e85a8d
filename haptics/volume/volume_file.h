// .vdb: distances in mm and labels, for every OpenVDB reader.
#pragma once

#include <openvdb/openvdb.h>

#include <filesystem>

#include "engine/contract/field_brick.h"
#include "haptics/dense_tissue.h"

namespace typodont::haptics {

/// In haptics' units.
struct StoredVolume {
  openvdb::FloatGrid::Ptr distance;  // distances in voxels
  openvdb::Int32Grid::Ptr tissue;    // tissue of every voxel
  openvdb::Int32Grid::Ptr before;    // filled: label before, plus one; null: no fillings
  // dense_tissue.h; filled: before. Null: kOwnHardness.
  openvdb::Int32Grid::Ptr hardness;
  VoxelFrame frame;
  double band = 0;  // m from the surface, of stored distances
  bool exact_outside = true;
  FilePlace place;
};

/// Every value checked. Throws Error with file and item.
StoredVolume read_volume(const std::filesystem::path& file);
/// Completely or not at all. The grids are spent. Throws Error.
void write_volume(const std::filesystem::path& file, const StoredVolume& volume);

}  // namespace typodont::haptics
