// OpenVDB trusts its files: a wrong length allocates gigabytes, and a wrong tree corrupts the heap. So a separate
// process with limited rights reads them and returns a list of blocks.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "haptics/volume/flat_grids.h"

namespace typodont::haptics {

/// Appends a seal: eight letters and the FNV-1a hash of the file, which OpenVDB ignores. It detects accidental damage,
/// not deliberate changes. Throws Error.
void seal_vdb(const std::filesystem::path& file);

/// Reads, in the guarded process (volume_reader.cpp), those of `grids` that the file contains. The result is cached by
/// content. Throws Error for a wrong seal, a length beyond the file, or a process that fails.
FlatGrids read_guarded(const std::filesystem::path& file, std::span<const std::string> grids);

}  // namespace typodont::haptics
