// OpenVDB trusts its files: a wrong length allocates gigabytes, a wrong tree corrupts the heap. So a guarded process
// reads them and returns a list of blocks.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "haptics/volume/flat_grids.h"

namespace typodont::haptics {

/// Eight letters and FNV-1a of all before, which OpenVDB ignores: against accident, not intent. Throws Error.
void seal_vdb(const std::filesystem::path& file);

/// Those of `grids` that are there, by a guarded process (volume_reader.cpp), also for our own files; cached per user
/// by content. Throws Error for a wrong seal, a length beyond the end, or a process that fails, exceeds its limits or
/// crashes.
FlatGrids read_guarded(const std::filesystem::path& file, std::span<const std::string> grids);

}  // namespace typodont::haptics
