// Reads .vdb files safely. OpenVDB trusts its files: a wrong length can allocate gigabytes, and a wrong tree can
// corrupt the heap. So the program never reads a .vdb file itself. A guarded process reads it and returns a plain list
// of blocks.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "haptics/volume/flat_grids.h"

namespace typodont::haptics {

/// Appends a seal to a finished .vdb file: eight letters and the FNV-1a hash of all bytes before. OpenVDB finds grids
/// by their position, so it ignores the seal. The seal detects accidental damage, but not deliberate changes, because
/// anybody can compute it. Throws Error if the file cannot be written.
void seal_vdb(const std::filesystem::path& file);

/// Reads those of `grids` that the file contains. A guarded process (volume_reader.cpp) reads every file, even one that
/// this program wrote. The result is cached per user, by a hash of the file's content. Throws Error if the hash in the
/// file's seal is wrong or if a length in the file points beyond its end. Also throws Error if the process fails (with
/// its message), exceeds its limit of memory or time, or crashes.
FlatGrids read_guarded(const std::filesystem::path& file, std::span<const std::string> grids);

}  // namespace typodont::haptics
