// Runs a long task on its own thread while the window stays usable. Reports the task's progress and result.
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
  /// Runs `work` on its own thread. `work` may throw any exception, including Cancelled; see failure().
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
  /// Returns the exception that the work threw; null if it threw none. Call it after done().
  std::exception_ptr failure() const { return failure_; }

 private:
  Progress progress_;
  std::exception_ptr failure_;
  std::atomic<bool> done_{false};
  // declared last, so that the destructor joins the thread before it destroys the members that the thread uses
  std::jthread thread_;
};

}  // namespace typodont
