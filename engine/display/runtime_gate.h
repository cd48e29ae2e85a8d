// Watches a thread that calls a headset's runtime, which may never return. The watching thread can abandon it: it then
// never runs this program's code again, so its data can go.
#pragma once

#include <atomic>
#include <chrono>
#include <thread>

#include "engine/base/clock.h"

namespace typodont::display {

class RuntimeGate {
 public:
  // Headset's thread, as the next ones. `call`: its name.
  void enter(const char* call) noexcept {
    call_.store(call, std::memory_order_relaxed);
    since_.store(now(), std::memory_order_relaxed);
    where_.store(kInside, std::memory_order_release);
  }
  /// Never returns if abandoned meanwhile.
  void leave() noexcept {
    int expected = kInside;
    if (where_.compare_exchange_strong(expected, kOutside, std::memory_order_acq_rel)) {
      since_.store(now(), std::memory_order_relaxed);
      return;
    }
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  }
  /// Ended, or no longer watched.
  void done() noexcept { where_.store(kDone, std::memory_order_release); }

  // s in the present call, 0 outside. Watching thread, as the next ones.
  double silent() const noexcept { return where_.load(std::memory_order_acquire) == kInside ? age() : 0; }
  /// s of own code since the last call; 0 in a call or after done().
  double busy() const noexcept { return where_.load(std::memory_order_acquire) == kOutside ? age() : 0; }
  const char* call() const noexcept { return call_.load(std::memory_order_relaxed); }
  /// True: it is in a call and will never return.
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
