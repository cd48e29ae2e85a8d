// "task" of a scene: description and rules. The ideal's geometry: engine/app/task/task.h.
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

/// The hand's, then the user's. `phase`, for implants: step n is complete at the end of phase n.
inline constexpr std::array<std::string_view, 10> kStepActions = {"move", "touch", "drill", "tool", "speed",
                                                                  "undo", "redo",  "view",  "hold", "phase"};

/// "text" or {"en": …, "de": …, "zh": …}; English is required.
struct TaskText {
  std::array<std::string, kLanguageCount> text;
  /// Or English without a translation.
  const std::string& in(Language language) const;
  bool empty() const { return text[0].empty(); }
};
TaskText read_task_text(const Json& json);

struct Task {
  TaskText title, goal;
  std::vector<TaskText> steps;
  // Of kStepActions, per step; empty: the user marks it.
  std::vector<std::string> step_actions;
  dvec3 axis_W{0, 0, 1};      // unit vector that points out of the opening
  std::optional<Json> ideal;  // JSON; other code reads its geometry
  std::vector<Json> protect;  // solids in JSON that must not be cut
  bool explore = false;       // explore, not cut
  std::vector<Json> region;   // JSON solids of the region to explore
};

/// Without the geometry of solids and ideal. Throws Error.
Task read_task(const Json& json);

/// Of the task, else of "score", else the defaults.
std::vector<ScoreRule> rules_of_scene(const Json& scene, const ScoreInput& input);
/// With the scene's rules and pass mark.
Score score_of_scene(const Json& scene, const ScoreInput& input);

}  // namespace typodont::session
