// The steps of a task, in order. A step is completed by a click, or by an action of the user if the task names an
// action ("done", see session::kStepActions). Main thread.
#pragma once

#include "engine/app/wiring.h"
#include "engine/contract/contact.h"
#include "engine/session/task.h"

namespace typodont {

/// The part of a session's state that steps depend on.
struct StepActions {
  ServoTick tick;
  SessionSettings settings;
  int undone = 0, redone = 0, views = 0;  // numbers of undos, redos and changes of the view since the session's start
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
  /// True if the current step is completed by an action instead of a click.
  bool waits() const;

  /// Evaluates the actions since the current step began. True if the step is now completed.
  bool follow(const StepActions& now);
  /// Completes the current step, or reopens the last one, by a click.
  void next();
  void back();

 private:
  session::Task task_;
  int current_ = 0;
  bool begun_ = false;  // the start values for the current step are stored
  StepActions start_;
  Nanos touched_ = 0, last_t_ = 0;  // ns of contact in this step
  double path_ = 0;                 // m, length of the hand's path in this step
  dvec3 last_p_{0};
};

}  // namespace typodont
