// Runs one long task at a time. When it ends, an action runs in the window's thread. Main thread only.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"

namespace typodont {

class BackgroundTask {
 public:
  explicit BackgroundTask(OperatorState& s) : s_(s) {}

  /// Starts `work`, and cancels an earlier task. After it has succeeded, look() calls `then`; after it has failed or
  /// was cancelled, `failed`, and then shows the reason.
  void begin(std::function<void(Progress&)> work, std::function<void()> then, std::function<void()> failed = {});
  /// The same for work that returns a result, which `take` receives.
  template <class Make, class Take>
  void make(Make make, Take take, std::function<void()> failed = {}) {
    const auto made = std::make_shared<std::optional<std::invoke_result_t<Make&, Progress&>>>();
    begin([made, make = std::move(make)](Progress& progress) mutable { made->emplace(make(progress)); },
          [made, take = std::move(take)]() mutable { take(std::move(**made)); }, std::move(failed));
  }
  bool under_way() const { return job_ != nullptr; }
  void cancel();
  /// Cancels the task and waits for its end.
  void drop();
  /// Updates the progress. True: the task has just ended.
  bool look();

 private:
  OperatorState& s_;
  std::unique_ptr<Job> job_;
  std::function<void()> then_, failed_;
};

}  // namespace typodont
