// An exercise as an instructor makes it in the window: a scene of its own in the user's folder.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/app/operator/state.h"
#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "engine/base/error.h"
#include "engine/base/progress.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Another feel and look of a tissue than the base's.
struct TissueMade {
  double stiffness = 1;        // of the base's
  std::optional<dvec3> color;  // sRGB
};

struct NewExercise {
  std::string name, goal;
  std::vector<std::string> steps;
  const Scene* base = nullptr;                   // what it was made from
  std::span<const PaintStroke> strokes;          // painted on top of the base's own paint
  const haptics::TissueVolume* ideal = nullptr;  // the result to aim at …
  std::filesystem::path ideal_mesh;              // … or a closed mesh of it; neither: as the base has it
  double mesh_unit_mm = 1;                       // of the mesh's file
  std::array<TissueMade, kTissueCount> tissues{};
  std::optional<std::vector<RuleChoice>> rules;  // what counts, and nothing else; nothing: as the base has it
};

/// An exercise that no session could use: one of its rules cannot be kept. Throws as Error does; who knows the reader's
/// language says it in his words.
class RuleRefused : public Error {
 public:
  RuleRefused(const Error& why, std::string name, bool without_target)
      : Error(why), rule(std::move(name)), no_target(without_target) {}
  std::string rule;  // its name, see session::known_score_names()
  bool no_target;    // none was given, and the ideal has nothing of this kind; else its numbers are out of range
};

/// What can count, as the base has it or, where it has none, as is usual.
std::vector<RuleChoice> rule_choices(const Scene& base);

/// The scene as text. `ideal_file`: where the ideal lies, beside the scene; empty: none but the base's.
std::string exercise_json(const NewExercise& exercise, const std::string& ideal_file);

/// Writes ~/Typodont/scenes/NAME.json, and the ideal beside it as NAME-ideal, once both were tried out as a session
/// would use them. An exercise of that name is replaced. Returns the scene file. Throws Error (RuleRefused), Cancelled:
/// then nothing has changed.
std::filesystem::path write_exercise(const NewExercise& exercise, Progress& progress);

}  // namespace typodont
