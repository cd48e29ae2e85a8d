// Supervises a thread that calls a headset's runtime. The runtime is not part of this program, and a call may take
// seconds or never return. A second thread, the watching thread, measures the duration of the call and can abandon the
// calling thread. An abandoned thread never executes this program's code again, so the data that it used can be
// destroyed.
#pragma once

#include <atomic>
#include <chrono>
#include <thread>

#include "engine/base/clock.h"

namespace typodont::display {

class RuntimeGate {
 public:
  // Marks the start of a call into the headset's runtime; `call` is its name. The headset's thread calls this function
  // and the next ones.
  void enter(const char* call) noexcept {
    call_.store(call, std::memory_order_relaxed);
    since_.store(now(), std::memory_order_relaxed);
    where_.store(kInside, std::memory_order_release);
  }
  /// Marks the end of a call into the runtime. Does not return if the watching thread abandoned this thread during the
  /// call.
  void leave() noexcept {
    int expected = kInside;
    if (where_.compare_exchange_strong(expected, kOutside, std::memory_order_acq_rel)) {
      since_.store(now(), std::memory_order_relaxed);
      return;
    }
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  }
  /// Marks that the thread has ended or that its supervision is over.
  void done() noexcept { where_.store(kDone, std::memory_order_release); }

  // Returns the duration in s of the present call into the headset's runtime; 0 outside a call. The watching thread
  // calls this function and the next ones.
  double silent() const noexcept { return where_.load(std::memory_order_acquire) == kInside ? age() : 0; }
  /// Returns for how many seconds the supervised thread has been executing the program's own code, since its last call
  /// into the runtime; 0 during a call, or after done().
  double busy() const noexcept { return where_.load(std::memory_order_acquire) == kOutside ? age() : 0; }
  const char* call() const noexcept { return call_.load(std::memory_order_relaxed); }
  /// Abandons the supervised thread. Returns true if the thread is inside a call into the runtime: it will never return
  /// from this call. Returns false if the thread is outside a call or has ended.
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
