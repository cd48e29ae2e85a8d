// An exercise as an instructor makes it in the window: a scene of its own in the user's folder.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "haptics/tissue_volume.h"

namespace typodont {

struct NewExercise {
  std::string name, goal;
  const Scene* base = nullptr;                   // what it was made from
  std::span<const PaintStroke> strokes;          // painted on top of the base's own paint
  const haptics::TissueVolume* ideal = nullptr;  // the result to aim at; null: as the base has it
};

/// The scene as text. `ideal_file`: where the ideal volume lies, beside the scene; empty: none.
std::string exercise_json(const NewExercise& exercise, const std::string& ideal_file);

/// Writes ~/Typodont/scenes/NAME.json, and the ideal beside it as NAME-ideal.vdb. An exercise of that name is replaced.
/// Returns the scene file. Throws Error.
std::filesystem::path write_exercise(const NewExercise& exercise);

}  // namespace typodont
