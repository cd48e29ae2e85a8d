// Long work beside the window: its own thread, its progress, its end.
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
  /// `work` runs on a thread of its own; it throws what went wrong, Cancelled included.
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
  /// After done(): what it threw, or nothing.
  std::exception_ptr failure() const { return failure_; }

 private:
  Progress progress_;
  std::exception_ptr failure_;
  std::atomic<bool> done_{false};
  std::jthread thread_;  // last: it uses the others, and is joined first
};

}  // namespace typodont
