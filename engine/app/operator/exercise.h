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
  double stiffness = 1;        // stiffness, divided by that in the base scene
  std::optional<dvec3> color;  // sRGB, colour of the tissue; empty: the base scene's colour
};

struct NewExercise {
  std::string name, goal;
  std::vector<std::string> steps;
  const Scene* base = nullptr;                   // base scene from which the exercise is made
  std::span<const PaintStroke> strokes;          // brush strokes that are added to those of the base scene
  const haptics::TissueVolume* ideal = nullptr;  // the ideal result as a volume; null: ideal_mesh is used
  // File with the ideal result as a closed mesh. If `ideal` and this name are empty, the base scene's ideal is used.
  std::filesystem::path ideal_mesh;
  double mesh_unit_mm = 1;  // mm, length of the unit in which the mesh file states coordinates
  std::array<TissueMade, kTissueCount> tissues{};
  std::optional<std::vector<RuleChoice>> rules;  // all rules of the score; empty: the base scene's rules
};

/// Error that is thrown if one of the rules of the exercise's score is invalid. The exercise is then not written. The
/// members name the rule and the fault, so that the caller can report the error in the user's language.
class RuleRefused : public Error {
 public:
  RuleRefused(const Error& why, std::string name, bool without_target)
      : Error(why), rule(std::move(name)), no_target(without_target) {}
  std::string rule;  // name of the invalid rule (see session::known_score_names())
  // Reason why the score rule is invalid. true: neither the rule nor the ideal preparation states a target value.
  // false: a number of the rule is out of range.
  bool no_target;
};

/// Lists the available score rules. A rule has its values in the base scene; a rule that the base scene does not
/// contain has default values.
std::vector<RuleChoice> rule_choices(const Scene& base);

/// Makes the scene's JSON text. `ideal_file`: ideal result, path relative to the scene; empty: the base scene's ideal.
std::string exercise_json(const NewExercise& exercise, const std::string& ideal_file);

/// Writes ~/Typodont/scenes/NAME.json, and the ideal result beside it as NAME-ideal. Before that, reads both new files
/// as a session would read them, to find errors. Then replaces any exercise of the same name. Returns the scene's file.
/// Throws Error (RuleRefused) or Cancelled; in both cases, no file has changed.
std::filesystem::path write_exercise(const NewExercise& exercise, Progress& progress);

}  // namespace typodont
