// What a thread requests from the system before a real-time loop.
#pragma once

#include <string>

namespace typodont {

struct RealtimeRequest {
  int priority = 80;  // SCHED_FIFO priority, 1 to 99
  static constexpr int kOwnCore = -2;
  // Core to pin to. -1: none. kOwnCore: the process's last one, with at least three cores and SCHED_FIFO granted;
  // without SCHED_FIFO, a thread runs better unpinned.
  int core = -1;
  bool lock_memory = true;  // true: mlockall() keeps all pages in memory
};

struct RealtimeGranted {
  bool fifo = false;
  bool pinned = false;
  bool memory_locked = false;
  // What was refused and how to fix it; empty: nothing. May be incomplete if memory is short.
  std::string note;
};

/// For the calling thread. Never throws; without SCHED_FIFO it runs at ordinary priority.
RealtimeGranted enter_realtime(const RealtimeRequest& request) noexcept;

/// Of the calling thread, to this nice value (1 to 19). Errors are ignored.
void lower_priority(int nice) noexcept;

/// Why SCHED_FIFO is refused and how to fix it; empty: granted. Asks in its own thread.
std::string realtime_refusal();

/// Keeps up to 256 MiB of freed memory, except arrays of 32 MiB or more; otherwise the system clears every page again.
/// Before other threads start; not in a library, because it affects the whole process.
void keep_freed_memory() noexcept;

/// In the calling thread. Otherwise decaying filters become slow.
void flush_denormals() noexcept;

/// Round to nearest, with denormals, whatever a library or parent has set: for the same bits on every thread.
void use_ieee_arithmetic() noexcept;

/// Spins from 60 µs before the deadline. Linux stops a SCHED_FIFO thread that always spins for 50 ms of every second.
void sleep_until(long long deadline_ns) noexcept;

}  // namespace typodont
