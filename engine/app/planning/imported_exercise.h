// Writes a scene for practice on imported tissue.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/base/partial_file.h"
#include "engine/base/progress.h"
#include "haptics/import/import.h"

namespace typodont {

/// Direction in which the crown of an imported tooth points in its file. The values mean +z, −z, +x, −x, +y and −y of
/// the file, in this order.
enum class Crown { kUp, kDown, kRight, kLeft, kBack, kFront };

/// m, position to which the middle of a crown's top is moved, because the shipped display rigs show this point
inline constexpr dvec3 kCrownTop{6.8e-3, 6.0e-3, 20.2e-3};

/// Returns the quarter turns (haptics::quarter_turns) that turn the crown to the direction +z; empty for no turn.
const char* upright_rotation(Crown crown);
/// Returns the direction in Crown that has the smallest angle to `up`.
Crown crown_along(const dvec3& up);

struct ImportedExercise {
  std::string name, description;
  Crown crown = Crown::kUp;
  // m, the point of the tissue that is moved to kCrownTop, in the coordinates before the tissue is turned upright;
  // empty: the middle of the tissue's top
  std::optional<dvec3> top;
};

/// Turns the tissue upright, moves it to the point that the shipped display rigs show, and writes the scene `file` and
/// the volume beside it, with the extension .vdb. Both files are written completely or not at all. Throws Error or
/// Cancelled; then nothing has changed.
void write_imported_exercise(const ImportedExercise& exercise, haptics::Imported& imported,
                             const std::filesystem::path& file, Over over, Progress& progress);

}  // namespace typodont
