// OpenVDB trusts its files: a wrong length allocates gigabytes, and a wrong tree corrupts the heap. Loading it also
// takes longer than the whole start of the program. So OpenVDB runs in a process of its own (vdb_process.cpp).
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "haptics/volume/flat_grids.h"

namespace typodont::haptics {

/// Reads the grids with these names that the file contains, in a process with limited rights. The result is cached
/// under the hash of the file's content. Throws Error for a wrong seal, a length beyond the file, or a process that
/// fails.
FlatGrids read_guarded(const std::filesystem::path& file, std::span<const std::string> grids);

/// Appends a seal: eight letters and the FNV-1a hash of the file, which OpenVDB ignores. It detects accidental damage,
/// not deliberate changes. Throws Error.
void seal_vdb(const std::filesystem::path& file);

/// Writes a volume file with a seal. `name`: the file for messages. Throws Error.
void write_vdb(const std::filesystem::path& file, const FlatGrids& grids, const std::filesystem::path& name);

/// Returns the zero set. Throws Error.
FlatMesh surface_of(const DistanceGrid& distances);

}  // namespace typodont::haptics
