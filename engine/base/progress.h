// Long work: how far it is, in words and as a share, and the wish that it stop. One worker, any number of watchers.
#pragma once

#include <algorithm>
#include <atomic>

#include "engine/base/error.h"

namespace typodont {

/// The work was asked to stop and did; whatever it was writing is not there.
class Cancelled : public RunFailure {
 public:
  Cancelled() : RunFailure("cancelled") {}
};

class Progress {
 public:
  // The worker's.
  /// From here on this is being done (a literal); its own share starts at `from` and ends at `to` of the whole.
  void stage(const char* what, double from, double to) {
    from_ = from, to_ = to;
    what_.store(what, std::memory_order_relaxed);
    at(0);
  }
  /// 0..1 of the stage. Throws Cancelled when the work should stop.
  void at(double share) {
    share_.store(from_ + std::clamp(share, 0.0, 1.0) * (to_ - from_), std::memory_order_relaxed);
    if (cancelled()) throw Cancelled();
  }

  // Watchers', signal handlers too.
  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }
  double share() const noexcept { return share_.load(std::memory_order_relaxed); }
  const char* what() const noexcept { return what_.load(std::memory_order_relaxed); }

 private:
  double from_ = 0, to_ = 1;  // the worker's
  std::atomic<double> share_{0};
  std::atomic<const char*> what_{""};
  std::atomic<bool> cancelled_{false};
};

}  // namespace typodont
