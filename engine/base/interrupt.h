// Signals that ask the program to end: SIGINT (Ctrl-C), SIGTERM (kill), SIGHUP (closed terminal).
#pragma once

#include <signal.h>

#include <array>

namespace typodont {

/// Each signal removes partial files and ends with exit status 1, or calls an InterruptHandler while one exists. An
/// ignored SIGHUP (nohup) stays ignored. Once, from the main thread.
void end_cleanly_on_interrupt();

/// While it exists, the signals call `handler`; then the previous one. Destroyed in reverse order. Main thread.
class InterruptHandler {
 public:
  explicit InterruptHandler(void (*handler)(int)) noexcept;
  ~InterruptHandler();
  InterruptHandler(const InterruptHandler&) = delete;
  InterruptHandler& operator=(const InterruptHandler&) = delete;

 private:
  std::array<struct sigaction, 3> before_{};
};

/// What end_now() calls first. Devices send zero force with it. Not for real-time loops.
void set_end_hook(void (*act)() noexcept) noexcept;

/// Removes partial files with a message; exit status 1. Signal-safe.
[[noreturn]] void end_now() noexcept;

}  // namespace typodont
