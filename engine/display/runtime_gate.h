// Between the thread that speaks with a headset's runtime and the one that watches over it. A runtime is a program of
// others: a call into it may take seconds, or never come back. The watcher sees how long it has taken and can give the
// thread up; a thread that was given up never runs a line of ours again, so that what it used may be destroyed.
#pragma once

#include <atomic>
#include <chrono>
#include <thread>

#include "engine/base/clock.h"

namespace typodont::display {

class RuntimeGate {
 public:
  // The headset's thread.
  void enter(const char* call) noexcept {
    call_.store(call, std::memory_order_relaxed);
    since_.store(now(), std::memory_order_relaxed);
    where_.store(kInside, std::memory_order_release);
  }
  /// Does not return where the thread was given up in the meantime.
  void leave() noexcept {
    int expected = kInside;
    if (where_.compare_exchange_strong(expected, kOutside, std::memory_order_acq_rel)) {
      since_.store(now(), std::memory_order_relaxed);
      return;
    }
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  }
  /// The thread has ended, or will do nothing more of interest.
  void done() noexcept { where_.store(kDone, std::memory_order_release); }

  // The watching thread.
  /// s that the runtime has had for the call it is in; 0 where it is in none.
  double silent() const noexcept { return where_.load(std::memory_order_acquire) == kInside ? age() : 0; }
  /// s that our own code has had since its last call; 0 where it is in one, or done.
  double busy() const noexcept { return where_.load(std::memory_order_acquire) == kOutside ? age() : 0; }
  const char* call() const noexcept { return call_.load(std::memory_order_relaxed); }
  /// True when the thread was inside a call: it will never come out. False: it runs, or has ended.
  bool give_up() noexcept {
    int expected = kInside;
    return where_.compare_exchange_strong(expected, kGivenUp, std::memory_order_acq_rel);
  }

 private:
  double age() const noexcept { return to_seconds(now() - since_.load(std::memory_order_relaxed)); }

  enum { kOutside, kInside, kGivenUp, kDone };
  std::atomic<int> where_{kOutside};
  std::atomic<const char*> call_{"its start"};
  std::atomic<Nanos> since_{now()};
};

}  // namespace typodont::display
