// The grids of a volume file as a plain list. A grid consists of blocks of voxels, and of tiles (larger cubes with one
// value). The guarded process, which has limited rights, opens the file and writes this list; the program reads the
// list. Every count is checked, so that no content of a file can do harm. Process and program come from the same build
// and run on the same machine, so the format needs no byte order and no version.
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
  double voxel = 0;                // edge of a voxel in the first grid, in the file's units; 0: voxels are not cubes
  openvdb::Vec3d origin{0, 0, 0};  // position of voxel (0,0,0) in the first grid, in the file's units
  bool exact_outside = true;
  // The place in the file from which the tissue was imported (FilePlace): rows of the rotation matrix, position in the
  // file's units, and the name of the axes.
  std::array<openvdb::Vec3d, 3> rotation{openvdb::Vec3d(1, 0, 0), {0, 1, 0}, {0, 0, 1}};
  openvdb::Vec3d file_origin{0, 0, 0};
  std::string axes;
};
/// Names of the metadata that contain the place.
inline constexpr std::array<const char*, 3> kFileRotation = {"typodont_file_rotation_x", "typodont_file_rotation_y",
                                                             "typodont_file_rotation_z"};
inline constexpr const char *kFileOrigin = "typodont_file_origin", *kFileAxes = "typodont_file_axes";

/// Reads only the grids `names`, if the file has them. Throws Error, openvdb::Exception, std::bad_alloc. A damaged file
/// may also corrupt memory, so only the guarded process calls this function.
FlatGrids read_vdb(const std::filesystem::path& file, std::span<const std::string> names);

/// Thrown if the destination has no space, or if a write failed for another reason.
struct WriteFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Exit status of the guarded process after a WriteFailure.
inline constexpr int kReaderCannotWrite = 3;

/// Writes the grids to an open file; `name` is for messages. Throws WriteFailure if writing fails, Error for a grid of
/// an unknown type.
void write_flat(int file, const std::string& name, const FlatGrids& grids);
/// Reads a list of grids. Throws Error(`name`, …) for any content that write_flat() would not write.
FlatGrids read_flat(const std::filesystem::path& file, const std::string& name);

}  // namespace typodont::haptics
