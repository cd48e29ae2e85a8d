// One long task at a time; its end triggers an action in the window's thread. Main thread only.
#pragma once

#include <functional>
#include <memory>

#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"

namespace typodont {

class BackgroundTask {
 public:
  explicit BackgroundTask(OperatorState& s) : s_(s) {}

  /// When `work` has succeeded, look() runs `then`. Cancels an earlier task.
  void begin(std::function<void(Progress&)> work, std::function<void()> then);
  bool under_way() const { return job_ != nullptr; }
  void cancel();
  /// Cancels and waits.
  void drop();
  /// Updates the progress. True: ended since the last call.
  bool look();

 private:
  OperatorState& s_;
  std::unique_ptr<Job> job_;
  std::function<void()> then_;
};

}  // namespace typodont
