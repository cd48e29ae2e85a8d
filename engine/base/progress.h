// Shows the progress of long work as text and as a fraction, and cancels the work on request. One thread does the work,
// and any number of threads may watch it.
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/interrupt.h"

namespace typodont {

/// Thrown when the user cancelled the work. The output file of the work does not exist then.
class Cancelled : public RunFailure {
 public:
  Cancelled() : RunFailure("cancelled; nothing was left half written") {}
};

class Progress {
 public:
  /// Constructor for work whose progress another thread shows.
  Progress() = default;
  /// Constructor that shows the progress on the terminal if the work takes longer than a second. If standard error is a
  /// terminal, one line is redrawn. Otherwise a line is printed after each tenth of the work. The first signal (SIGINT,
  /// SIGTERM, SIGHUP) cancels the work. The second signal ends the program at once (interrupt.h). Only one such object
  /// may exist at a time.
  explicit Progress(std::string_view line);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // The thread that does the work calls stage() and at(). stage() begins a stage of the work, with the name `what` (a
  // string literal). During the stage, the progress of the whole work increases from `from` to `to`.
  void stage(const char* what, double from = 0, double to = 1);
  /// Sets the progress of the stage, from 0 to 1. Throws Cancelled if the work should stop.
  void at(double fraction);

  // Asks the thread that does the work to stop. Threads that watch the progress, and signal handlers, may call this
  // function and the next ones.
  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }
  double fraction() const noexcept { return fraction_.load(std::memory_order_relaxed); }
  const char* what() const noexcept { return what_.load(std::memory_order_relaxed); }

 private:
  void show();

  // Progress of the whole work (0..1) when the present stage begins, and when it ends. Used only by the thread that
  // does the work.
  double from_ = 0, to_ = 1;
  std::atomic<double> fraction_{0};
  std::atomic<const char*> what_{""};
  std::atomic<bool> cancelled_{false};
  std::string line_;  // name of the work on the terminal; if empty, nothing is printed
  Nanos began_ = 0;
  int shown_ = -1;
  bool terminal_ = false;
  std::optional<InterruptHandler> on_interrupt_;
};

}  // namespace typodont
