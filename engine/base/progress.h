// Progress of long work as text and fraction, and its cancellation. One thread works, any number watch.
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/interrupt.h"

namespace typodont {

/// By the user. The work's output file does not exist then.
class Cancelled : public RunFailure {
 public:
  Cancelled() : RunFailure("cancelled; nothing was left half written") {}
};

class Progress {
 public:
  /// Another thread shows the progress.
  Progress() = default;
  /// Shows it and the time left on the terminal after a second: one redrawn line, or a line per tenth without a
  /// terminal. The first SIGINT, SIGTERM or SIGHUP cancels, the second ends the program (interrupt.h). One at a time.
  explicit Progress(std::string_view line);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Working thread, as at(). `what`: a literal. In this stage the whole work goes from `from` to `to`.
  void stage(const char* what, double from = 0, double to = 1);
  /// Of the stage, 0 to 1. Throws Cancelled if the work should stop.
  void at(double fraction);

  // For watching threads and signal handlers, as the next ones.
  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }
  double fraction() const noexcept { return fraction_.load(std::memory_order_relaxed); }
  const char* what() const noexcept { return what_.load(std::memory_order_relaxed); }

 private:
  void show();

  // 0..1 of the whole work, at the stage's start and end. Working thread only.
  double from_ = 0, to_ = 1;
  std::atomic<double> fraction_{0};
  std::atomic<const char*> what_{""};
  std::atomic<bool> cancelled_{false};
  std::string line_;  // on the terminal; empty: nothing
  Nanos began_ = 0;
  int shown_ = -1;
  bool terminal_ = false;
  std::optional<InterruptHandler> on_interrupt_;
};

}  // namespace typodont
