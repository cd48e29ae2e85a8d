// Runs one long task at a time beside the window, and an action in the window when it is done. Main thread.
#pragma once

#include <functional>
#include <memory>

#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"

namespace typodont {

class LongWork {
 public:
  explicit LongWork(OperatorState& s) : s_(s) {}

  /// Runs `work` on its own thread, and after its success `then` on this one. Cancels a running task first and waits
  /// for its end.
  void begin(std::function<void(Progress&)> work, std::function<void()> then);
  bool under_way() const { return job_ != nullptr; }
  void cancel();
  /// Cancels the task and waits for its end.
  void drop();
  /// Shows the progress. True if the task has just ended.
  bool look();

 private:
  OperatorState& s_;
  std::unique_ptr<Job> job_;
  std::function<void()> then_;
};

}  // namespace typodont
