// A long task on its own thread, with progress and result.
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
  /// `work` may throw anything, including Cancelled; see failure().
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
  /// What the work threw; null: nothing. After done().
  std::exception_ptr failure() const { return failure_; }

 private:
  Progress progress_;
  std::exception_ptr failure_;
  std::atomic<bool> done_{false};
  // last, so that it joins before what it uses is destroyed
  std::jthread thread_;
};

}  // namespace typodont
