// Reads "task" of a scene: description and rules. engine/app/task/task.h reads the geometry of the ideal shape.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/json.h"
#include "engine/base/keys.h"
#include "engine/session/score.h"
#include "engine/session/strings.h"

namespace typodont::session {

/// Actions that complete a step: first those of the hand, then those of the user. "phase", for implants: step n is
/// complete at the end of phase n.
inline constexpr std::array<std::string_view, 11> kStepActions = {"move", "touch", "drill",     "tool", "speed", "undo",
                                                                  "redo", "view",  "viewpoint", "hold", "phase"};

/// A text in several languages: "text", or {"en": …, "de": …, "zh": …}; English is required.
struct TaskText {
  std::array<std::string, kLanguageCount> text;
  /// The text in this language; English if not translated.
  const std::string& in(Language language) const;
  bool empty() const { return text[0].empty(); }
};
TaskText read_task_text(const Json& json);
/// Declares a key with such a text.
void describe_text(Keys& keys, Key key, TaskText& text, std::string_view meaning);

/// A step of the task: its text, the action that completes it, and its tool.
struct TaskStep : TaskText {
  std::string done;  // element of kStepActions that completes the step; empty: the user marks the step as done
  std::string tool;  // name of the scene's tool that the session takes when the step begins; empty: keeps the tool
};

struct Task {
  TaskText title, goal;
  std::vector<TaskStep> steps;
  dvec3 axis_W{0, 0, 1};         // unit vector that points out of the cavity's opening
  std::optional<Json> ideal;     // ideal shape as JSON; other code reads its geometry
  std::vector<Json> protect;     // solids in JSON that must not be cut
  bool explore = false;          // true: the task is to explore, not to cut
  std::vector<Json> region;      // solids in JSON that contain the region to explore
  std::vector<ProbeSite> sites;  // pockets to measure instead of a region
  std::vector<TaskText> site_names;
  StatedScore score;
};

/// Declares the keys of a task. `ideal` declares those of the ideal shape. Solids and ideal shape are not read.
void describe_task(Keys& keys, Task& task, void (*ideal)(Keys&));
/// Reads the task, except the geometry of its solids and of the ideal shape. Throws Error.
Task read_task(const Json& json);

/// Rules of the task, else of "score", else the defaults.
std::vector<ScoreRule> rules_of_scene(const Json& scene, const ScoreInput& input);
/// Score with the scene's rules and pass mark.
Score score_of_scene(const Json& scene, const ScoreInput& input);

}  // namespace typodont::session
