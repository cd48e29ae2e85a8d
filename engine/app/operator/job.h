// Work on another thread, and what follows at its end. Main thread only, except for the work itself.
#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <type_traits>
#include <utility>

#include "engine/base/progress.h"

namespace typodont {

/// One piece of work at a time. Its destructor cancels the work and waits for its end.
class Job {
 public:
  using Failed = std::function<void(const std::exception&)>;

  /// Starts `work`; earlier work is dropped. After its success, look() calls `then`; after an exception (Cancelled
  /// after cancel()), `failed`, which may throw it again with `throw;`.
  void begin(std::function<void(Progress&)> work, std::function<void()> then = {}, Failed failed = {}) {
    drop();
    running_ = std::make_unique<Running>(std::move(work), std::move(then), std::move(failed));
  }
  /// The same for work that returns a result, which `take` receives.
  template <class Make, class Take>
  void make(Make make, Take take, Failed failed = {}) {
    const auto made = std::make_shared<std::optional<std::invoke_result_t<Make&, Progress&>>>();
    begin([made, make = std::move(make)](Progress& progress) mutable { made->emplace(make(progress)); },
          [made, take = std::move(take)]() mutable { take(std::move(**made)); }, std::move(failed));
  }
  bool under_way() const { return running_ != nullptr; }
  /// True: look() will end the work.
  bool done() const { return running_ && running_->done.load(std::memory_order_acquire); }
  /// Progress of the work under way; otherwise null.
  const Progress* progress() const { return running_ ? &running_->progress : nullptr; }
  void cancel() {
    if (running_) running_->progress.cancel();
  }
  /// Cancels the work and waits for its end. Nothing follows.
  void drop() { running_.reset(); }
  /// True: the work has just ended. Throws what `then` or `failed` throws; without `failed`, the work's exception.
  bool look() {
    if (!done()) return false;
    const auto ended = std::move(running_);
    try {
      if (ended->failure) std::rethrow_exception(ended->failure);
    } catch (const std::exception& e) {
      if (!ended->failed) throw;
      ended->failed(e);
      return true;
    }
    if (ended->then) ended->then();
    return true;
  }

 private:
  struct Running {
    Running(std::function<void(Progress&)> work, std::function<void()> after, Failed after_failure)
        : then(std::move(after)), failed(std::move(after_failure)), thread([this, run = std::move(work)] {
            try {
              run(progress);
            } catch (...) {
              failure = std::current_exception();
            }
            done.store(true, std::memory_order_release);
          }) {}
    ~Running() { progress.cancel(); }

    std::function<void()> then;
    Failed failed;
    Progress progress;
    std::exception_ptr failure;
    std::atomic<bool> done{false};
    // Declared last, so that the thread is joined before the members that it uses are destroyed.
    std::jthread thread;
  };
  std::unique_ptr<Running> running_;
};

}  // namespace typodont
