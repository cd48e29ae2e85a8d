// An instructor's exercise, stored as a scene in the user's folder.
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

/// Where it differs from the base scene.
struct TissueMade {
  double stiffness = 1;        // stiffness, divided by that in the base scene
  std::optional<dvec3> color;  // sRGB; empty: the base scene's
};

struct NewExercise {
  std::string name, goal;
  std::vector<std::string> steps;
  const Scene* base = nullptr;                   // base scene from which the exercise is made
  std::span<const PaintStroke> strokes;          // added to the base scene's
  const haptics::TissueVolume* ideal = nullptr;  // null: ideal_mesh is used
  // Closed mesh. Without both, the base scene's ideal.
  std::filesystem::path ideal_mesh;
  double mesh_unit_mm = 1;  // mm per unit of the mesh file
  std::array<TissueMade, kTissueCount> tissues{};
  std::optional<std::vector<RuleChoice>> rules;  // all of them; empty: the base scene's
};

/// Names rule and fault, for a message in the user's language. Nothing is written.
class RuleRefused : public Error {
 public:
  RuleRefused(const Error& why, std::string name, bool without_target)
      : Error(why), rule(std::move(name)), no_target(without_target) {}
  std::string rule;  // name of the invalid rule (see session::known_score_names())
  // true: no target value in rule or ideal; false: a number out of range
  bool no_target;
};

/// With the values of the base scene, otherwise defaults.
std::vector<RuleChoice> rule_choices(const Scene& base);

/// JSON text. `ideal_file`: relative to the scene; empty: the base scene's.
std::string exercise_json(const NewExercise& exercise, const std::string& ideal_file);

/// ~/Typodont/scenes/NAME.json and NAME-ideal beside it, first read as a session would; then replaces files of the same
/// name. Returns the scene. Throws Error (RuleRefused) or Cancelled without changing a file.
std::filesystem::path write_exercise(const NewExercise& exercise, Progress& progress);

}  // namespace typodont
