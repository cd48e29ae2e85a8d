// Long work: how far it is, in words and as a share, and the wish that it stop. One worker, any number of watchers.
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/interrupt.h"

namespace typodont {

/// The work was asked to stop and did; what it was writing is not there.
class Cancelled : public RunFailure {
 public:
  Cancelled() : RunFailure("cancelled; nothing was left half written") {}
};

class Progress {
 public:
  /// Watched by another thread.
  Progress() = default;
  /// Shown on the terminal once it takes longer than a second: one line redrawn when standard error is a terminal,
  /// otherwise each tenth printed once. The first Ctrl-C (SIGINT, SIGTERM, SIGHUP) cancels the work, the second one
  /// ends the program at once (interrupt.h). One at a time.
  explicit Progress(std::string_view line);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // The worker's.
  /// From here on this is being done (a literal); its own shares go from `from` to `to` of the whole.
  void stage(const char* what, double from = 0, double to = 1);
  /// 0..1 of the stage. Throws Cancelled when the work should stop.
  void at(double share);

  // Watchers', signal handlers too.
  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }
  double share() const noexcept { return share_.load(std::memory_order_relaxed); }
  const char* what() const noexcept { return what_.load(std::memory_order_relaxed); }

 private:
  void show();

  double from_ = 0, to_ = 1;  // the worker's
  std::atomic<double> share_{0};
  std::atomic<const char*> what_{""};
  std::atomic<bool> cancelled_{false};
  std::string line_;  // on the terminal; empty: not there
  Nanos began_ = 0;
  int shown_ = -1;
  bool terminal_ = false;
  std::optional<InterruptHandler> on_interrupt_;
};

}  // namespace typodont
