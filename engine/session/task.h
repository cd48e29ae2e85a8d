// Reads the block "task" of a scene: its description and its rules, for the report and the score. Other code reads the
// ideal's geometry (engine/app/task/task.h).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/json.h"
#include "engine/session/score.h"
#include "engine/session/strings.h"

namespace typodont::session {

/// Actions that can complete a step of a task. The hand moves, touches or drills; the user changes the tool, the speed
/// or the view, uses undo or redo, or presses the emergency key. The last action, `phase`, is for implant exercises:
/// step n is complete at the end of phase n.
inline constexpr std::array<std::string_view, 10> kStepActions = {"move", "touch", "drill", "tool", "speed",
                                                                  "undo", "redo",  "view",  "hold", "phase"};

/// A text in all languages, written in JSON as "text" or as {"en": …, "de": …, "zh": …}. The English text is required.
struct TaskText {
  std::array<std::string, kLanguageCount> text;
  /// Returns the text in this language, or the English text if there is no translation.
  const std::string& in(Language language) const;
  bool empty() const { return text[0].empty(); }
};
TaskText read_task_text(const Json& json);

struct Task {
  TaskText title, goal;
  std::vector<TaskText> steps;
  // For each step, the action that completes it (one of kStepActions). If the action is empty, the user marks the step
  // as done.
  std::vector<std::string> step_actions;
  dvec3 axis_W{0, 0, 1};      // unit vector that points out of the opening
  std::optional<Json> ideal;  // description of the ideal (target shape) in JSON; other code reads its geometry
  std::vector<Json> protect;  // solids in JSON that must not be cut
  bool explore = false;       // true if the trainee should explore the tissue and not cut it
  std::vector<Json> region;   // solids in JSON that define the region to explore
};

/// Reads and checks a task, but not the geometry of its solids and of its ideal (target shape). Throws Error.
Task read_task(const Json& json);

/// Returns the rules of a scene: those of its task, or those of its block "score" if there is no task, or the default
/// rules if there is neither.
std::vector<ScoreRule> rules_of_scene(const Json& scene, const ScoreInput& input);
/// Computes the score with the rules and the pass mark of a scene.
Score score_of_scene(const Json& scene, const ScoreInput& input);

}  // namespace typodont::session
