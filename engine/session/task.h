// A scene's "task": what is asked for, in words and rules. Where the ideal's geometry comes from is the program's to
// read (engine/app/task/task.h); here is what report and score need.
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

/// What a step may wait for: the hand moved, touched, drilled; a tool, the speed, an undo, a redo, a view; the hold
/// key; the phase of an implant exercise that has the step's number.
inline constexpr std::array<std::string_view, 10> kStepDeeds = {"move", "touch", "drill", "tool", "speed",
                                                                "undo", "redo",  "view",  "hold", "phase"};

/// "text", or {"en": …, "de": …, "zh": …} with at least "en".
struct TaskText {
  std::array<std::string, kLanguageCount> text;
  /// English where there is no translation.
  const std::string& in(Language language) const;
  bool empty() const { return text[0].empty(); }
};
TaskText read_task_text(const Json& json);

struct Task {
  TaskText title, goal;
  std::vector<TaskText> steps;
  std::vector<std::string> step_deeds;  // one for each step: what does it, of kStepDeeds; empty: it is ticked off
  dvec3 axis_W{0, 0, 1};                // unit, out of the opening
  std::optional<Json> ideal;            // read by the program
  std::vector<Json> protect;            // solids
  bool explore = false;                 // to be explored, not cut
  std::vector<Json> region;             // solids: where
};

/// Reads and checks everything but solids and the ideal. Throws Error.
Task read_task(const Json& json);

/// The rules of a scene: its task's, else its "score" block's, else the defaults.
std::vector<ScoreRule> rules_of_scene(const Json& scene, const ScoreInput& input);
/// By these rules and the scene's pass mark.
Score score_of_scene(const Json& scene, const ScoreInput& input);

}  // namespace typodont::session
