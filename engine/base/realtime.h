// What a thread asks of the operating system before it enters a real-time loop.
#pragma once

#include <string>

namespace typodont {

struct RealtimeRequest {
  int priority = 80;  // SCHED_FIFO priority
  static constexpr int kOwnCore = -2;
  int core = -1;  // pinned core; -1: not pinned; kOwnCore: the last one this process may use, where there are
                  // three or more and SCHED_FIFO was granted (an ordinary thread does better where there is room)
  bool lock_memory = true;  // mlockall
};

struct RealtimeGranted {
  bool fifo = false;
  bool pinned = false;
  bool memory_locked = false;
  std::string note;  // in plain words what was refused and what mends it, while there is memory for them; empty: all
                     // was granted
};

/// Calling thread. Never throws: a refusal is reported, and the loop runs at ordinary priority.
RealtimeGranted enter_realtime(const RealtimeRequest& request) noexcept;

/// Why the system refuses SCHED_FIFO to the threads of this process, and what mends it; empty: it grants it. Asks by a
/// thread of its own.
std::string realtime_refusal();

/// Calling thread: denormals become zero, so that decaying filters cost the same as loud ones.
void flush_denormals() noexcept;

/// Calling thread: rounds to nearest and keeps denormals, whatever a library or the thread that started it has set.
/// What must give the same bits on every thread calls this first.
void use_ieee_arithmetic() noexcept;

/// Sleeps until the moment, then spins the last 60 µs: a FIFO thread that only spins is throttled 50 ms a second.
void sleep_until(long long deadline_ns) noexcept;

}  // namespace typodont
