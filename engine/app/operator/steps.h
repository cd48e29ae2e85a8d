// The steps of a task, in order. The user completes a step by a click. If the task states an action for the step (key
// "done", for example "touch"), the user completes the step by this action instead. Main thread only.
#pragma once

#include "engine/app/wiring.h"
#include "engine/contract/contact.h"
#include "engine/session/task.h"

namespace typodont {

/// The data of a session from which Steps finds out whether the user has completed the current step.
struct StepActions {
  ServoTick tick;
  SessionSettings settings;
  /// numbers of undos, redos and changes of the view since the session's start
  int undone = 0, redone = 0, views = 0;
  bool held = false;
  std::size_t phase = 0;  // number of completed phases of an implant exercise
};

class StepWatcher {
 public:
  StepWatcher() = default;
  explicit StepWatcher(const session::Task& task) : task_(task) {}

  int count() const { return static_cast<int>(task_.steps.size()); }
  /// Returns the index of the first step that is not done; equal to count() if all steps are done.
  int current() const { return current_; }
  const session::TaskText& text(int step) const { return task_.steps[static_cast<std::size_t>(step)]; }
  /// Returns true if an action completes the current step; false if a click completes it.
  bool waits() const;

  /// Checks the user's actions since the current step began. Returns true if they have now completed the step.
  bool follow(const StepActions& now);
  /// Completes the current step after a click of the user. back() marks the last completed step as not done.
  void next();
  void back();

 private:
  session::Task task_;
  int current_ = 0;
  bool begun_ = false;  // true: the state at the start of the current step is stored
  StepActions start_;
  /// touched_: ns, contact time in the current step; last_t_: ns, time of the last tick
  Nanos touched_ = 0, last_t_ = 0;
  double path_ = 0;  // m, length of the hand's path in the current step
  dvec3 last_p_{0};
};

}  // namespace typodont
