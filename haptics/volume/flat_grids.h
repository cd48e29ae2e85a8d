// A volume file's grids as a plain list of tiles and blocks: what the guarded process writes and the program reads.
// Every count in it is checked, so that no content of it can do harm. Same machine, same build: no byte order, no
// versions.
#pragma once

#include <openvdb/openvdb.h>

#include <filesystem>
#include <map>
#include <span>
#include <stdexcept>
#include <string>

namespace typodont::haptics {

struct FlatGrids {
  std::map<std::string, openvdb::GridBase::Ptr> grids;  // openvdb::FloatGrid or openvdb::Int32Grid
  double voxel = 0;                                     // of the first one, in the file's units; 0: not a cube
  openvdb::Vec3d origin{0, 0, 0};                       // the same
  bool exact_outside = true;
};

/// Reads those of `names` that the file has, and nothing else of it. Throws Error, openvdb::Exception, std::bad_alloc;
/// a damaged file may do worse, so only the guarded process calls it.
FlatGrids read_vdb(const std::filesystem::path& file, std::span<const std::string> names);

/// The place has no room, or does not take what is written for another reason.
struct WriteFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Exit status of the guarded process after a WriteFailure.
inline constexpr int kReaderCannotWrite = 3;

/// To an open file; `name` is for messages. Throws WriteFailure when it cannot be written, Error for a grid of another
/// kind.
void write_flat(int file, const std::string& name, const FlatGrids& grids);
/// Throws Error(`name`, …) for anything that write_flat() does not write.
FlatGrids read_flat(const std::filesystem::path& file, const std::string& name);

}  // namespace typodont::haptics
