// Reads a scene's "task": its description and its rules, for the report and the score. The program reads the ideal's
// geometry (engine/app/task/task.h).
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

/// Actions that can complete a step. The hand moved, touched or drilled; the user changed the tool, the speed or the
/// view, used undo or redo, or pressed the hold key; or the implant exercise finished the phase with the step's number.
inline constexpr std::array<std::string_view, 10> kStepActions = {"move", "touch", "drill", "tool", "speed",
                                                                  "undo", "redo",  "view",  "hold", "phase"};

/// A text in all languages: "text", or {"en": …, "de": …, "zh": …}; "en" is required.
struct TaskText {
  std::array<std::string, kLanguageCount> text;
  /// Returns the English text if there is no translation.
  const std::string& in(Language language) const;
  bool empty() const { return text[0].empty(); }
};
TaskText read_task_text(const Json& json);

struct Task {
  TaskText title, goal;
  std::vector<TaskText> steps;
  // for each step: the action that completes it, one of kStepActions; empty: the user marks the step as done
  std::vector<std::string> step_actions;
  dvec3 axis_W{0, 0, 1};      // unit, direction out of the opening
  std::optional<Json> ideal;  // the ideal as JSON; the program reads its geometry
  std::vector<Json> protect;  // solids that must not be cut
  bool explore = false;       // true if the task is to explore, not to cut
  std::vector<Json> region;   // solids that define the region to explore
};

/// Reads and checks everything except solids and the ideal. Throws Error.
Task read_task(const Json& json);

/// The rules of a scene. They come from its task; otherwise from its "score" block; otherwise they are the defaults.
std::vector<ScoreRule> rules_of_scene(const Json& scene, const ScoreInput& input);
/// Computes the score by these rules and the scene's pass mark.
Score score_of_scene(const Json& scene, const ScoreInput& input);

}  // namespace typodont::session
