// An exercise that an instructor creates in the window. It is stored as a scene in the user's folder.
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

/// Stiffness and colour of a tissue in the new exercise, if they differ from the base scene.
struct TissueMade {
  double stiffness = 1;        // ratio to the stiffness in the base scene
  std::optional<dvec3> color;  // sRGB, colour of the tissue; empty: the base scene's colour
};

struct NewExercise {
  std::string name, goal;
  std::vector<std::string> steps;
  const Scene* base = nullptr;                   // base scene from which the exercise is made
  std::span<const PaintStroke> strokes;          // strokes painted in addition to the base's own strokes
  const haptics::TissueVolume* ideal = nullptr;  // the ideal as a volume; null: see ideal_mesh
  // File with the ideal as a closed mesh. If both `ideal` and this name are empty, the base scene's ideal is used.
  std::filesystem::path ideal_mesh;
  double mesh_unit_mm = 1;  // mm, length of the unit in which the mesh file states coordinates
  std::array<TissueMade, kTissueCount> tissues{};
  std::optional<std::vector<RuleChoice>> rules;  // the complete list of rules; empty: the base's rules
};

/// Error because of a rule of the exercise. The caller can report it in the user's language.
class RuleRefused : public Error {
 public:
  RuleRefused(const Error& why, std::string name, bool without_target)
      : Error(why), rule(std::move(name)), no_target(without_target) {}
  std::string rule;  // name of the rule; see session::known_score_names()
  // Reason. true: the rule has no target value, and the ideal preparation does not give one either; false: a number of
  // the rule is out of range.
  bool no_target;
};

/// Lists the available rules. A rule has the values of the base scene, or default values if the base scene lacks it.
std::vector<RuleChoice> rule_choices(const Scene& base);

/// Returns the scene as JSON text. `ideal_file`: path of the ideal relative to the scene; empty: the base's ideal.
std::string exercise_json(const NewExercise& exercise, const std::string& ideal_file);

/// Writes ~/Typodont/scenes/NAME.json, and the ideal beside it as NAME-ideal. An exercise of the same name is replaced.
/// Before that, both files are checked as a session would use them. Returns the scene's file. Throws Error
/// (RuleRefused) or Cancelled; then no file has changed.
std::filesystem::path write_exercise(const NewExercise& exercise, Progress& progress);

}  // namespace typodont
