// The steps of a task, one after the other: each is ticked off by whoever watches, or by what was done, where the task
// says which deed counts ("done", see session::kStepDeeds). Main thread.
#pragma once

#include "engine/app/wiring.h"
#include "engine/contract/contact.h"
#include "engine/session/task.h"

namespace typodont {

/// What a session shows of itself, as far as steps look at it.
struct Deeds {
  ServoTick tick;
  SessionSettings settings;
  int undone = 0, redone = 0, views = 0;  // counts since the session's start
  bool held = false;
  std::size_t phase = 0;  // of an implant exercise: how many are over
};

class StepWatcher {
 public:
  StepWatcher() = default;
  explicit StepWatcher(const session::Task& task) : task_(task) {}

  int count() const { return static_cast<int>(task_.steps.size()); }
  /// The first that is not done; count() when all are.
  int current() const { return current_; }
  const session::TaskText& text(int step) const { return task_.steps[static_cast<std::size_t>(step)]; }
  /// True when the current step waits for a deed rather than for a tick.
  bool waits() const;

  /// Looks at what was done since the current step began. True when that was it.
  bool follow(const Deeds& now);
  /// Ticked off, or taken back, by hand.
  void next();
  void back();

 private:
  session::Task task_;
  int current_ = 0;
  bool begun_ = false;  // the current step has a starting point
  Deeds start_;
  Nanos touched_ = 0, last_t_ = 0;  // ns with the head on tissue in this step
  double path_ = 0;                 // m
  dvec3 last_p_{0};
};

}  // namespace typodont
