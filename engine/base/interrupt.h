// Signals that ask the program to end: SIGINT (Ctrl-C), SIGTERM (kill), SIGHUP (closed terminal).
#pragma once

#include <signal.h>

#include <array>

namespace typodont {

/// After this call, SIGINT, SIGTERM and SIGHUP remove partial files and end the program with exit status 1, or call the
/// InterruptHandler if there is one. An ignored SIGHUP (nohup) remains ignored. Call once, from the main thread.
void end_cleanly_on_interrupt();

/// While this object exists, the signals call `handler`; then the previous handler again. Destroy the newest object
/// first. Main thread.
class InterruptHandler {
 public:
  explicit InterruptHandler(void (*handler)(int)) noexcept;
  ~InterruptHandler();
  InterruptHandler(const InterruptHandler&) = delete;
  InterruptHandler& operator=(const InterruptHandler&) = delete;

 private:
  std::array<struct sigaction, 3> before_{};
};

/// Sets a function that end_now() calls first; devices use it to send zero force. Not for real-time loops.
void set_end_hook(void (*act)() noexcept) noexcept;

/// Removes partial files with a message, and ends the program with exit status 1. Signal-safe.
[[noreturn]] void end_now() noexcept;

}  // namespace typodont
