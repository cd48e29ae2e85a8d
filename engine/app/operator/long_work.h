// What takes long, one thing at a time, beside the window, and what the window does once it is done. Main thread.
#pragma once

#include <functional>
#include <memory>

#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"

namespace typodont {

class LongWork {
 public:
  explicit LongWork(OperatorState& s) : s_(s) {}

  /// `work` runs on a thread of its own; `then` in this one, once it has succeeded. What was under way is cancelled,
  /// and its end waited for.
  void begin(std::function<void(Progress&)> work, std::function<void()> then);
  bool under_way() const { return job_ != nullptr; }
  void cancel();
  /// Cancels, and waits for the end.
  void drop();
  /// Shows how far it is. True when it has just ended.
  bool look();

 private:
  OperatorState& s_;
  std::unique_ptr<Job> job_;
  std::function<void()> then_;
};

}  // namespace typodont
