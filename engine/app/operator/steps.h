// A task's steps in order. A step is completed by a click, or by its action (key "done", for example "touch"). Main
// thread only.
#pragma once

#include "engine/app/wiring.h"
#include "engine/contract/contact.h"
#include "engine/session/task.h"

namespace typodont {

/// What Steps needs of a session.
struct StepActions {
  ServoTick tick;
  SessionSettings settings;
  /// since the start
  int undone = 0, redone = 0, views = 0;
  bool held = false;
  std::size_t phase = 0;  // number of completed phases of an implant exercise
};

class StepWatcher {
 public:
  StepWatcher() = default;
  explicit StepWatcher(const session::Task& task) : task_(task) {}

  int count() const { return static_cast<int>(task_.steps.size()); }
  /// First step that is not done; count() if all are.
  int current() const { return current_; }
  const session::TaskText& text(int step) const { return task_.steps[static_cast<std::size_t>(step)]; }
  /// An action completes the current step, not a click.
  bool waits() const;

  /// True: the actions since the step began complete it.
  bool follow(const StepActions& now);
  /// After a click; back() reopens the last one.
  void next();
  void back();

 private:
  void begin(const StepActions& now);

  session::Task task_;
  int current_ = 0;
  bool begun_ = false;  // the state at the step's start is stored
  StepActions start_;
  /// ns: contact in the step, time of the last tick
  Nanos touched_ = 0, last_t_ = 0;
  double path_ = 0;  // m, the hand's path in the step
  dvec3 last_p_{0};
};

}  // namespace typodont
