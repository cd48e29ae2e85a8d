// A second process that holds on to the device: zero force when the program is killed outright or stopped.
//
// device_safety.h covers every end that a program can notice. SIGKILL, the kernel's out-of-memory killer and SIGSTOP it
// cannot; without a keeper the force then stays until the device's own watchdog lets go (0.5 s on the open-hardware
// arms; nobody knows for how long behind a service). The keeper is a child that does nothing but wait for its parent to
// end or to fall silent, and then writes the command that stands for zero.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <span>

#include "engine/base/clock.h"

namespace typodont::haptics {

class Keeper {
 public:
  /// Set-up time. `descriptor`: of the open device, kept by the child; negative: no keeper (simulated links). `zero`:
  /// what to write. Where no process can be made there is none, and running() says so.
  Keeper(int descriptor, std::span<const std::uint8_t> zero);
  /// After zero was sent: the child goes.
  ~Keeper();
  Keeper(const Keeper&) = delete;
  Keeper& operator=(const Keeper&) = delete;

  bool running() const noexcept { return child_ > 0; }
  pid_t child() const noexcept { return child_; }
  /// With every write to the device. Any thread, any signal handler.
  void told(bool force, Nanos t) noexcept {
    if (!shared_) return;
    shared_->last_write.store(t, std::memory_order_relaxed);
    shared_->force_out.store(force, std::memory_order_release);
  }

  static constexpr Nanos kSilence =
      10'000'000;  // ns without a write while a force is out; the watchdog thread's
                   // patience is a fifth of it, so this is for a process that stands still

 private:
  struct Shared {
    std::atomic<Nanos> last_write{0};
    std::atomic<bool> force_out{false};
  };
  static_assert(std::atomic<Nanos>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
                "shared between processes");

  Shared* shared_ = nullptr;
  pid_t child_ = -1;
  int alive_ = -1;  // our end of a pipe: the child reads its end when we are gone
};

}  // namespace typodont::haptics
