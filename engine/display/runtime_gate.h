// Watches a thread that calls a headset's runtime, because such a call may never return. The watching thread can
// abandon the other thread, which then never runs code of this program again, so its data can be destroyed.
#pragma once

#include <atomic>
#include <chrono>
#include <thread>

#include "engine/base/clock.h"

namespace typodont::display {

class RuntimeGate {
 public:
  // The following functions are for the headset's thread.
  /// Marks the begin of a call of the runtime. `call`: its name.
  void enter(const char* call) noexcept {
    call_.store(call, std::memory_order_relaxed);
    since_.store(now(), std::memory_order_relaxed);
    where_.store(kInside, std::memory_order_release);
  }
  /// Marks the end of the call. If the thread was abandoned meanwhile, the function never returns.
  void leave() noexcept {
    int expected = kInside;
    if (where_.compare_exchange_strong(expected, kOutside, std::memory_order_acq_rel)) {
      since_.store(now(), std::memory_order_relaxed);
      return;
    }
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  }
  /// Marks that the thread has ended or does not have to be watched any longer.
  void done() noexcept { where_.store(kDone, std::memory_order_release); }

  // The following functions are for the watching thread.
  /// Duration of the current call, s; 0 outside a call.
  double silent() const noexcept { return where_.load(std::memory_order_acquire) == kInside ? age() : 0; }
  /// Time since the last call, s; 0 during a call and after done().
  double busy() const noexcept { return where_.load(std::memory_order_acquire) == kOutside ? age() : 0; }
  const char* call() const noexcept { return call_.load(std::memory_order_relaxed); }
  /// Abandons the thread if it is inside a call, from which it then never returns. False: it is not inside a call.
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
