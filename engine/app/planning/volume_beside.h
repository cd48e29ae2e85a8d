// The volume that is written beside an exercise.
#pragma once

#include <filesystem>

#include "engine/base/partial_file.h"

namespace typodont {

/// The same name with .vdb.
std::filesystem::path volume_beside(const std::filesystem::path& file);

/// Throws Error, unless new or named by the existing exercise.
void require_volume_beside(const std::filesystem::path& file, Over over);

}  // namespace typodont
