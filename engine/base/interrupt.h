// Handles the signals that ask the program to end: SIGINT (Ctrl-C), SIGTERM (kill) and SIGHUP (the terminal was
// closed).
#pragma once

#include <signal.h>

#include <array>

namespace typodont {

/// Installs handlers for SIGINT, SIGTERM and SIGHUP. Each of these signals then removes the partially written files
/// (PartialFile) and ends the program with exit status 1. While an InterruptHandler exists, the signals call its
/// handler instead. If the process ignores SIGHUP (nohup), SIGHUP stays ignored. Call once from the main thread.
void end_cleanly_on_interrupt();

/// While this object exists, SIGINT, SIGTERM and SIGHUP call `handler`. The destructor restores the previous handler.
/// Nested objects must be destroyed in the reverse order of their construction. Main thread.
class InterruptHandler {
 public:
  explicit InterruptHandler(void (*handler)(int)) noexcept;
  ~InterruptHandler();
  InterruptHandler(const InterruptHandler&) = delete;
  InterruptHandler& operator=(const InterruptHandler&) = delete;

 private:
  std::array<struct sigaction, 3> before_{};
};

/// Sets a function that end_now() calls before it does anything else. Devices use this function to send zero force. Not
/// for real-time loops.
void set_end_hook(void (*act)() noexcept) noexcept;

/// Removes the partially written files, prints a message about them, and ends the process with exit status 1. Signal
/// handlers may call this function.
[[noreturn]] void end_now() noexcept;

}  // namespace typodont
