// Runs one long task at a time while the window stays usable. When the task is done, executes an action in the window's
// thread. Main thread only.
#pragma once

#include <functional>
#include <memory>

#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"

namespace typodont {

class BackgroundTask {
 public:
  explicit BackgroundTask(OperatorState& s) : s_(s) {}

  /// Runs `work` on its own thread. When `work` has succeeded, look() runs `then`. If an earlier task is still running,
  /// begin() first cancels that task.
  void begin(std::function<void(Progress&)> work, std::function<void()> then);
  bool under_way() const { return job_ != nullptr; }
  void cancel();
  /// Cancels the task and waits for its end.
  void drop();
  /// Updates the displayed progress. Returns true if the task has ended since the last call.
  bool look();

 private:
  OperatorState& s_;
  std::unique_ptr<Job> job_;
  std::function<void()> then_;
};

}  // namespace typodont
