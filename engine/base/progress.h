// Progress of long work as text and as a fraction, and a request to cancel the work. One thread works; any number of
// threads may watch.
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/interrupt.h"

namespace typodont {

/// The work stopped because it was cancelled. Its output file does not exist.
class Cancelled : public RunFailure {
 public:
  Cancelled() : RunFailure("cancelled; nothing was left half written") {}
};

class Progress {
 public:
  /// Constructor for work that another thread watches.
  Progress() = default;
  /// Constructor that shows the work on the terminal once the work takes longer than a second. If standard error is a
  /// terminal, one line is redrawn; otherwise each tenth of the work prints a line. The first Ctrl-C (SIGINT, SIGTERM,
  /// SIGHUP) cancels the work, and the second one ends the program at once (interrupt.h). Only one such object may
  /// exist at a time.
  explicit Progress(std::string_view line);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Called by the worker.
  /// Begins a stage with the name `what` (a literal). The stage's progress 0..1 maps to `from`..`to` of the whole.
  void stage(const char* what, double from = 0, double to = 1);
  /// Sets the progress of the stage, 0..1. Throws Cancelled if the work should stop.
  void at(double fraction);

  // Called by watchers and signal handlers.
  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }
  double fraction() const noexcept { return fraction_.load(std::memory_order_relaxed); }
  const char* what() const noexcept { return what_.load(std::memory_order_relaxed); }

 private:
  void show();

  double from_ = 0, to_ = 1;  // begin and end of the stage, fractions of the whole; worker only
  std::atomic<double> fraction_{0};
  std::atomic<const char*> what_{""};
  std::atomic<bool> cancelled_{false};
  std::string line_;  // name on the terminal; empty: no output on the terminal
  Nanos began_ = 0;
  int shown_ = -1;
  bool terminal_ = false;
  std::optional<InterruptHandler> on_interrupt_;
};

}  // namespace typodont
