// Writes a scene for practice on imported tissue.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/base/partial_file.h"
#include "engine/base/progress.h"
#include "haptics/import/import.h"

namespace typodont {

/// Direction of the crown in the file: +z, −z, +x, −x, +y, −y.
enum class Crown { kUp, kDown, kRight, kLeft, kBack, kFront };

/// Place for the top of an imported crown, m, frame W. The displays in the shipped rig files show this place.
inline constexpr dvec3 kCrownTop{6.8e-3, 6.0e-3, 20.2e-3};

/// Rotation that turns the crown to +z, for haptics::quarter_turns; empty: none is needed.
const char* upright_rotation(Crown crown);
/// The direction with the smallest angle to `up`.
Crown crown_along(const dvec3& up);

struct ImportedExercise {
  std::string name, description;
  Crown crown = Crown::kUp;
  // Point that is moved to kCrownTop, m, before the rotation; empty: the middle of the tissue's top.
  std::optional<dvec3> top;
};

/// Turns and moves the tissue, and writes the scene `file` and its .vdb, both or neither. Throws Error or Cancelled.
void write_imported_exercise(const ImportedExercise& exercise, haptics::Imported& imported,
                             const std::filesystem::path& file, Over over, Progress& progress);

}  // namespace typodont
