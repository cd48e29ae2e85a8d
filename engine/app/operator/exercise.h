// An exercise that an instructor makes in the window: a scene in the user's folder.
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

/// Stiffness and colour of a tissue; they may differ from the base scene.
struct TissueMade {
  double stiffness = 1;        // factor on the stiffness in the base scene
  std::optional<dvec3> color;  // sRGB; empty: the base scene's colour
};

struct NewExercise {
  std::string name, goal;
  std::vector<std::string> steps;
  const Scene* base = nullptr;                   // base scene from which the exercise is made
  std::span<const PaintStroke> strokes;          // strokes painted in addition to the base's own strokes
  const haptics::TissueVolume* ideal = nullptr;  // the ideal as tissue
  // the ideal as a closed mesh; if neither `ideal` nor a mesh is given, the base's ideal is used
  std::filesystem::path ideal_mesh;
  double mesh_unit_mm = 1;  // mm, unit of the mesh file
  std::array<TissueMade, kTissueCount> tissues{};
  std::optional<std::vector<RuleChoice>> rules;  // the complete list of rules; empty: the base's rules
};

/// Error: the exercise cannot be used because of one of its rules. A caller that knows the user's language can report
/// the error in that language.
class RuleRefused : public Error {
 public:
  RuleRefused(const Error& why, std::string name, bool without_target)
      : Error(why), rule(std::move(name)), no_target(without_target) {}
  std::string rule;  // name of the rule; see session::known_score_names()
  // Reason of the refusal. true: neither the rule nor the ideal preparation gives a target value; false: a number of
  // the rule is out of range.
  bool no_target;
};

/// The available rules with the base's values, or with default values if the base has no rules.
std::vector<RuleChoice> rule_choices(const Scene& base);

/// Returns the scene as JSON text. `ideal_file`: path of the ideal relative to the scene; empty: the base's ideal.
std::string exercise_json(const NewExercise& exercise, const std::string& ideal_file);

/// Writes ~/Typodont/scenes/NAME.json, and the ideal beside it as NAME-ideal. Before writing, checks both files as a
/// session would use them. Replaces an exercise of the same name. Returns the scene's file. If it throws Error
/// (RuleRefused) or Cancelled, nothing has changed.
std::filesystem::path write_exercise(const NewExercise& exercise, Progress& progress);

}  // namespace typodont
