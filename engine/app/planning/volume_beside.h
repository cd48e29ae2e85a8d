// The tissue volume of an exercise, which a command writes beside the exercise's scene file.
#pragma once

#include <filesystem>

#include "engine/base/partial_file.h"

namespace typodont {

/// Returns the volume of the exercise `file`: the same name with the extension .vdb.
std::filesystem::path volume_beside(const std::filesystem::path& file);

/// Throws Error if the volume beside the exercise `file` may not be written. The user names only the exercise, so an
/// existing volume may be replaced only if the existing exercise names this volume.
void require_volume_beside(const std::filesystem::path& file, Over over);

}  // namespace typodont
