// An instructor's exercise: a scene in the user's folder.
#pragma once

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

struct NewExercise {
  std::string name, goal;
  std::vector<std::string> steps;
  const Scene* base = nullptr;                   // base scene from which the exercise is made
  std::span<const PaintStroke> strokes;          // added to the strokes of the base scene
  const haptics::TissueVolume* ideal = nullptr;  // null: ideal_mesh is used
  // File with a closed mesh of the ideal shape. Without mesh and tissue, the ideal shape of the base scene is used.
  std::filesystem::path ideal_mesh;
  double mesh_unit_mm = 1;                                 // mm per unit of the mesh file
  PerTissue stiffness = SessionSettings::every_tissue(1);  // factor on each tissue's stiffness in the base scene
  std::optional<std::vector<RuleChoice>> rules;            // all rules of the score; empty: the base scene's rules
};

/// Thrown for an invalid score rule, before any file is written. States rule and fault, for a message to the user.
class RuleRefused : public Error {
 public:
  RuleRefused(const Error& why, std::string name, bool without_target)
      : Error(why), rule(std::move(name)), no_target(without_target) {}
  std::string rule;  // name of the invalid rule (see session::known_score_names())
  // True: neither the rule nor the ideal shape gives a target. False: a number is out of range.
  bool no_target;
};

/// All rules of the score, with the values of the base scene if it has them, otherwise with defaults.
std::vector<RuleChoice> rule_choices(const Scene& base);

/// The exercise as JSON text. `ideal_file`: path relative to the scene; empty: the ideal shape of the base scene.
std::string exercise_json(const NewExercise& exercise, const std::string& ideal_file);

/// Writes ~/Typodont/scenes/NAME.json and NAME-ideal. New files have temporary names until they are checked; then
/// they replace old files. Returns the scene file. Throws Error (RuleRefused) or Cancelled without changing a file.
std::filesystem::path write_exercise(const NewExercise& exercise, Progress& progress);

}  // namespace typodont
