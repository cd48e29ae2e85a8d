// Grids as a list of blocks and tiles, from the guarded process to the program, which checks every count. Both are of
// one build and machine: no byte order, no version.
#pragma once

#include <openvdb/openvdb.h>

#include <array>
#include <filesystem>
#include <map>
#include <span>
#include <stdexcept>
#include <string>

namespace typodont::haptics {

struct FlatGrids {
  std::map<std::string, openvdb::GridBase::Ptr> grids;  // each grid is an openvdb::FloatGrid or an openvdb::Int32Grid
  double voxel = 0;                                     // of the first grid, file's units; 0: no cubes
  openvdb::Vec3d origin{0, 0, 0};                       // of voxel (0,0,0), first grid, file's units
  bool exact_outside = true;
  // FilePlace: rows of the rotation, position in file's units, axes.
  std::array<openvdb::Vec3d, 3> rotation{openvdb::Vec3d(1, 0, 0), {0, 1, 0}, {0, 0, 1}};
  openvdb::Vec3d file_origin{0, 0, 0};
  std::string axes;
};
/// Names of the metadata that contain the place.
inline constexpr std::array<const char*, 3> kFileRotation = {"typodont_file_rotation_x", "typodont_file_rotation_y",
                                                             "typodont_file_rotation_z"};
inline constexpr const char *kFileOrigin = "typodont_file_origin", *kFileAxes = "typodont_file_axes";

/// Only `names`, where there. Throws Error, openvdb::Exception, std::bad_alloc. A damaged file may corrupt memory:
/// guarded process only.
FlatGrids read_vdb(const std::filesystem::path& file, std::span<const std::string> names);

/// No space, or another failed write.
struct WriteFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Exit status after it.
inline constexpr int kReaderCannotWrite = 3;

/// `name`: for messages. Throws WriteFailure, or Error for an unknown type.
void write_flat(int file, const std::string& name, const FlatGrids& grids);
/// Throws Error(`name`, …) for anything that write_flat() would not write.
FlatGrids read_flat(const std::filesystem::path& file, const std::string& name);

}  // namespace typodont::haptics
