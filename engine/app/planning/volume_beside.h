// The volume that is written beside an exercise's scene file.
#pragma once

#include <filesystem>

#include "engine/base/partial_file.h"

namespace typodont {

/// The volume's path: the scene's path with extension .vdb.
std::filesystem::path volume_beside(const std::filesystem::path& file);

/// Throws Error if the volume must not be written, for example if a file at its path does not belong to this scene.
void require_volume_beside(const std::filesystem::path& file, Over over);

}  // namespace typodont
