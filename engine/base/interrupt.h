// Signals that ask the program to end: SIGINT (Ctrl-C), SIGTERM (kill) and SIGHUP (the terminal was closed).
#pragma once

#include <signal.h>

#include <array>

namespace typodont {

/// From now on, one of these signals removes what is half written (PartialFile) and ends the program with exit status
/// 1, wherever nobody else handles it. A SIGHUP that is ignored, as nohup has it, stays ignored. Main thread, once.
void end_in_order_on_interrupt();

/// While it lives, these signals call `handler` instead; afterwards what was before. Nested ones end in the reverse
/// order of their begin. Main thread.
class InterruptHandler {
 public:
  explicit InterruptHandler(void (*handler)(int)) noexcept;
  ~InterruptHandler();
  InterruptHandler(const InterruptHandler&) = delete;
  InterruptHandler& operator=(const InterruptHandler&) = delete;

 private:
  std::array<struct sigaction, 3> before_{};
};

/// Called first by end_now(); set-up time. For devices: zero force.
void set_last_act(void (*act)() noexcept) noexcept;

/// Removes what is half written, says so, and ends the process with exit status 1. Safe in signal handlers.
[[noreturn]] void end_now() noexcept;

}  // namespace typodont
