// Progress of long work, as text and fraction, and its cancellation. One thread works, any number of threads watch.
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/interrupt.h"

namespace typodont {

/// Thrown when the user cancels. The work's output file does not exist then.
class Cancelled : public RunFailure {
 public:
  Cancelled() : RunFailure("cancelled; nothing was left half written") {}
};

class Progress {
 public:
  /// Progress that another thread of the program shows, for example in a window.
  Progress() = default;
  /// Progress on the terminal, with the time left, shown after one second: one line that is redrawn, or a line per 10 %
  /// if the output is no terminal. The first SIGINT, SIGTERM or SIGHUP cancels the work, the second ends the program.
  /// Only one such object may exist at a time.
  explicit Progress(std::string_view line);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Begins a stage, in which the fraction of the whole work rises from `from` to `to`. `what`: a string literal.
  // Working thread only.
  void stage(const char* what, double from = 0, double to = 1);
  /// Sets the finished fraction of the stage, 0 to 1. Throws Cancelled if the work should stop. Working thread only.
  void at(double fraction);

  // The next functions are for watching threads and signal handlers.
  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }
  double fraction() const noexcept { return fraction_.load(std::memory_order_relaxed); }
  const char* what() const noexcept { return what_.load(std::memory_order_relaxed); }

 private:
  void show();

  // Fraction of the whole work at the start and end of the stage, 0 to 1. Working thread only.
  double from_ = 0, to_ = 1;
  std::atomic<double> fraction_{0};
  std::atomic<const char*> what_{""};
  std::atomic<bool> cancelled_{false};
  std::string line_;  // text of the line on the terminal; empty: shows nothing
  Nanos began_ = 0;
  int shown_ = -1;
  bool terminal_ = false;
  std::optional<InterruptHandler> on_interrupt_;
};

}  // namespace typodont
