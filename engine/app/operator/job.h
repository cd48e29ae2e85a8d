// A long task on its own thread, with its result.
#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <memory>
#include <thread>

#include "engine/base/progress.h"

namespace typodont {

class Job {
 public:
  /// Starts the work. It may throw any exception; see failure().
  explicit Job(std::function<void(Progress&)> work)
      : thread_([this, run = std::move(work)] {
          try {
            run(progress_);
          } catch (...) {
            failure_ = std::current_exception();
          }
          done_.store(true, std::memory_order_release);
        }) {}
  ~Job() { progress_.cancel(); }
  Job(const Job&) = delete;
  Job& operator=(const Job&) = delete;

  Progress& progress() { return progress_; }
  bool done() const { return done_.load(std::memory_order_acquire); }
  /// The work's exception; null: none. Valid after done().
  std::exception_ptr failure() const { return failure_; }

 private:
  Progress progress_;
  std::exception_ptr failure_;
  std::atomic<bool> done_{false};
  // Declared last, so that the thread is joined before the members that it uses are destroyed.
  std::jthread thread_;
};

}  // namespace typodont
