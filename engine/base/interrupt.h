// Signals that ask the program to end: SIGINT (Ctrl-C), SIGTERM (kill) and SIGHUP (the terminal was closed).
#pragma once

#include <signal.h>

#include <array>

namespace typodont {

/// From now on, one of these signals removes partially written files (PartialFile) and ends the program with exit
/// status 1, unless an InterruptHandler exists. An ignored SIGHUP (nohup) stays ignored. Main thread, once.
void end_cleanly_on_interrupt();

/// While this object lives, these signals call `handler`; its destructor restores the previous handler. Nested handlers
/// must be destroyed in the reverse order of their construction. Main thread.
class InterruptHandler {
 public:
  explicit InterruptHandler(void (*handler)(int)) noexcept;
  ~InterruptHandler();
  InterruptHandler(const InterruptHandler&) = delete;
  InterruptHandler& operator=(const InterruptHandler&) = delete;

 private:
  std::array<struct sigaction, 3> before_{};
};

/// Sets a function that end_now() calls first. Devices use it to send zero force. Set-up time.
void set_end_hook(void (*act)() noexcept) noexcept;

/// Removes partially written files, reports the removal, and ends the process with exit status 1. Safe in signal
/// handlers.
[[noreturn]] void end_now() noexcept;

}  // namespace typodont
