// OpenVDB trusts its files: a damaged length costs gigabytes, a damaged tree the heap. So this program never reads one
// by itself: a guarded process does, and hands over a plain list of blocks.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "haptics/volume/flat_grids.h"

namespace typodont::haptics {

/// Appends a seal to a finished .vdb file: eight letters and the FNV-1a of all bytes before. OpenVDB, which finds its
/// grids by position, never sees it. The seal detects accidents, not intent: anybody can compute it again. Throws Error
/// when the file cannot be written.
void seal_vdb(const std::filesystem::path& file);

/// Those of `grids` that the file holds, read by a process that can do no harm (volume_reader.cpp), whoever made the
/// file; the result is kept by content in the user's cache. Throws Error where the seal is broken, a stated length lies
/// beyond the file, or that process fails (with its message), takes too much memory or time, or dies.
FlatGrids read_guarded(const std::filesystem::path& file, std::span<const std::string> grids);

}  // namespace typodont::haptics
