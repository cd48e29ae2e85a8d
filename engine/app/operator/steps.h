// Watches the steps of a task, in order. A click completes a step, or the action that its key "done" states, for
// example "touch". Main thread only.
#pragma once

#include <cstdint>
#include <string_view>

#include "engine/app/wiring.h"
#include "engine/contract/contact.h"
#include "engine/session/task.h"

namespace typodont {

/// State of the session, from which StepWatcher recognises the user's actions.
struct StepActions {
  ServoTick tick;
  SessionSettings settings;
  std::int32_t chosen_tool = -1;  // index of the tool that was chosen last; negative: none
  /// Numbers of undos and redos since the session's start.
  int undone = 0, redone = 0;
  /// Numbers of changes since the session's start: of what the picture shows, and of where it is seen from.
  int views = 0, viewpoints = 0;
  bool held = false;
  std::size_t phase = 0;  // number of completed phases of an implant exercise
};

class StepWatcher {
 public:
  StepWatcher() = default;
  explicit StepWatcher(const session::Task& task) : task_(task) {}

  int count() const { return static_cast<int>(task_.steps.size()); }
  /// Index of the first step that is not done; count() if all are done.
  int current() const { return current_; }
  const session::TaskText& text(int step) const { return task_.steps[static_cast<std::size_t>(step)]; }
  /// Name of the tool that the current step needs; empty: any tool.
  std::string_view tool() const { return current_ < count() ? current_step().tool : std::string_view(); }
  /// True if an action of the user, not a click, completes the current step.
  bool waits() const;

  /// `now`: state of the session. Returns true if the user's actions have completed the current step.
  bool follow(const StepActions& now);
  /// next() completes the current step after a click; back() opens the last completed step again.
  void next();
  void back();

 private:
  const session::TaskStep& current_step() const { return task_.steps[static_cast<std::size_t>(current_)]; }
  void begin(const StepActions& now);
  bool takes_another_tool(const StepActions& now) const;

  session::Task task_;
  int current_ = 0;
  bool begun_ = false;  // true: the session's state at the step's start is stored
  StepActions start_;
  /// ns: contact duration in this step; last tick's time.
  Nanos touched_ = 0, last_t_ = 0;
  double path_ = 0;  // m, length of the hand's path in this step
  dvec3 last_p_{0};
};

}  // namespace typodont
