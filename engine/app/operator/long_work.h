// Runs one long task at a time while the window continues. When the task is done, executes an action in the window's
// thread. Main thread.
#pragma once

#include <functional>
#include <memory>

#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"

namespace typodont {

class BackgroundTask {
 public:
  explicit BackgroundTask(OperatorState& s) : s_(s) {}

  /// Runs `work` on its own thread. If it succeeds, then runs `then` on this thread. First cancels a running task and
  /// waits for its end.
  void begin(std::function<void(Progress&)> work, std::function<void()> then);
  bool under_way() const { return job_ != nullptr; }
  void cancel();
  /// Cancels the task and waits for its end.
  void drop();
  /// Updates the displayed progress. True if the task has just ended.
  bool look();

 private:
  OperatorState& s_;
  std::unique_ptr<Job> job_;
  std::function<void()> then_;
};

}  // namespace typodont
