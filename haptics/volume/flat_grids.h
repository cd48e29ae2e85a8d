// Passes grids as lists of blocks and tiles from the guarded process (vdb_guard.h) to the program, which checks every
// count. Both come from one build on one machine, so the format needs no byte order and no version.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <span>
#include <stdexcept>
#include <string>

#include "haptics/volume/openvdb.h"

namespace typodont::haptics {

struct FlatGrids {
  std::map<std::string, openvdb::GridBase::Ptr> grids;  // each grid is an openvdb::FloatGrid or an openvdb::Int32Grid
  double voxel = 0;                // voxel size of the first grid in the file's unit; 0: voxels are not cubes
  openvdb::Vec3d origin{0, 0, 0};  // position of the first grid's voxel (0,0,0), file's unit
  bool exact_outside = true;
  // Data of FilePlace: rows of the rotation, position in the file's unit, axes.
  std::array<openvdb::Vec3d, 3> rotation{openvdb::Vec3d(1, 0, 0), {0, 1, 0}, {0, 0, 1}};
  openvdb::Vec3d file_origin{0, 0, 0};
  std::string axes;
};
/// Names of the metadata that store the pose of imported tissue in its source file (FilePlace).
inline constexpr std::array<const char*, 3> kFileRotation = {"typodont_file_rotation_x", "typodont_file_rotation_y",
                                                             "typodont_file_rotation_z"};
inline constexpr const char *kFileOrigin = "typodont_file_origin", *kFileAxes = "typodont_file_axes";

/// Reads the grids in `names` that the file contains. Throws Error, openvdb::Exception, std::bad_alloc. A damaged file
/// may corrupt memory, so only the guarded process calls it.
FlatGrids read_vdb(const std::filesystem::path& file, std::span<const std::string> names);

/// A write failed, for example because the disk is full.
struct WriteFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Exit status of the reader process after a WriteFailure.
inline constexpr int kReaderCannotWrite = 3;

/// `name`: used in messages. Throws WriteFailure, or Error for an unknown type of grid.
void write_flat(int file, const std::string& name, const FlatGrids& grids);
/// Throws Error(`name`, …) for content that write_flat() never writes.
FlatGrids read_flat(const std::filesystem::path& file, const std::string& name);

}  // namespace typodont::haptics
