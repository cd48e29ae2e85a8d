// A child process that sends zero force if its parent ends or stops writing (SIGKILL, SIGSTOP, out of memory). Without
// the child, the last force would stay until the device's own watchdog acts.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <span>

#include "engine/base/clock.h"

namespace typodont::haptics {

class WatchdogProcess {
 public:
  /// Starts the child at set-up. `descriptor`: the open device, which the child keeps open; if negative (simulated
  /// links), no child starts. `zero`: command for zero force. If no process can be created, running() returns false.
  WatchdogProcess(int descriptor, std::span<const std::uint8_t> zero);
  /// Ends the child process. Call after zero force was sent.
  ~WatchdogProcess();
  WatchdogProcess(const WatchdogProcess&) = delete;
  WatchdogProcess& operator=(const WatchdogProcess&) = delete;

  bool running() const noexcept { return child_ > 0; }
  pid_t child() const noexcept { return child_; }
  /// Records a write to the device at time t; call it with every write. `force`: the written force is not zero. Any
  /// thread or signal handler.
  void note_write(bool force, Nanos t) noexcept {
    if (!shared_) return;
    shared_->last_write.store(t, std::memory_order_relaxed);
    shared_->force_out.store(force, std::memory_order_release);
  }

  // Time without a write, while a force is on, after which the child sends zero force, ns. Five times the time of the
  // watchdog thread, because the child acts only if the parent no longer runs.
  static constexpr Nanos kSilence = 10'000'000;

 private:
  struct Shared {
    std::atomic<Nanos> last_write{0};
    std::atomic<bool> force_out{false};
  };
  static_assert(std::atomic<Nanos>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
                "shared between processes");

  Shared* shared_ = nullptr;
  pid_t child_ = -1;
  int alive_ = -1;  // this process's end of a pipe; the child detects when it is closed
};

}  // namespace typodont::haptics
