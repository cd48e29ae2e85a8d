// A second process that keeps the device open and sends zero force if the program is killed or stopped.
// device_safety.h covers every end that a program can handle. But SIGKILL, the kernel's out-of-memory killer and
// SIGSTOP cannot be handled. Without a watchdog process, the last force would then stay until the device's own
// watchdog ends it (0.5 s on the open-hardware arms; unknown behind a service). The watchdog process is a child
// process that waits until its parent ends or stops writing, and then writes the command for zero force.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <span>

#include "engine/base/clock.h"

namespace typodont::haptics {

class WatchdogProcess {
 public:
  /// Set-up time. `descriptor`: descriptor of the open device; the child keeps it open. Negative: no watchdog process
  /// is started (simulated links). `zero`: the bytes to write. If no process can be created, there is no watchdog
  /// process, and running() returns false.
  WatchdogProcess(int descriptor, std::span<const std::uint8_t> zero);
  /// Ends the child. Call after zero force was sent.
  ~WatchdogProcess();
  WatchdogProcess(const WatchdogProcess&) = delete;
  WatchdogProcess& operator=(const WatchdogProcess&) = delete;

  bool running() const noexcept { return child_ > 0; }
  pid_t child() const noexcept { return child_; }
  /// Call with every write to the device. Any thread, any signal handler.
  void note_write(bool force, Nanos t) noexcept {
    if (!shared_) return;
    shared_->last_write.store(t, std::memory_order_relaxed);
    shared_->force_out.store(force, std::memory_order_release);
  }

  // ns, limit of the time without a write while a force is on; five times the watchdog's timeout, because this
  // process only covers a parent that no longer runs
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
  int alive_ = -1;  // our end of a pipe; the child detects when this end closes
};

}  // namespace typodont::haptics
