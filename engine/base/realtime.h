// Real-time settings that a thread requests from the operating system before it enters a real-time loop.
#pragma once

#include <string>

namespace typodont {

struct RealtimeRequest {
  int priority = 80;  // SCHED_FIFO priority
  static constexpr int kOwnCore = -2;
  // Core to pin the thread to. -1: not pinned. kOwnCore: the last core of this process, if it has at least three and
  // SCHED_FIFO was granted (an ordinary thread does better if the scheduler can move it).
  int core = -1;
  bool lock_memory = true;  // mlockall
};

struct RealtimeGranted {
  bool fifo = false;
  bool pinned = false;
  bool memory_locked = false;
  // States what was refused and how to fix it, if there is memory for the text. Empty: everything was granted.
  std::string note;
};

/// Applies to the calling thread. Never throws: a refusal is reported, and the loop runs at ordinary priority.
RealtimeGranted enter_realtime(const RealtimeRequest& request) noexcept;

/// Reason why the system refuses SCHED_FIFO to this process, and how to fix it; empty if the system grants it. The
/// function requests SCHED_FIFO in a separate thread.
std::string realtime_refusal();

/// Calling thread: treats denormals as zero, so that decaying filters take no longer than others.
void flush_denormals() noexcept;

/// Calling thread: rounds to nearest and keeps denormals, whatever a library or the parent thread has set. Code that
/// must give the same bits on every thread calls this first.
void use_ieee_arithmetic() noexcept;

/// Sleeps until 60 µs before the deadline, then spins. Linux would throttle a FIFO thread that only spins, by 50 ms per
/// second.
void sleep_until(long long deadline_ns) noexcept;

}  // namespace typodont
