// A thread's requests to the system before its real-time loop.
#pragma once

#include <string>

namespace typodont {

struct RealtimeRequest {
  int priority = 80;  // SCHED_FIFO priority, 1 to 99
  static constexpr int kOwnCore = -2;
  // Processor core for the thread; -1: any. kOwnCore: the last core of the process, if the process has at least three
  // cores and SCHED_FIFO is granted. Without SCHED_FIFO, a thread runs better if it is not pinned.
  int core = -1;
  bool lock_memory = true;  // true: mlockall() keeps all pages in memory
};

struct RealtimeGranted {
  bool fifo = false;
  bool pinned = false;
  bool memory_locked = false;
  // What was refused and how to fix it; empty: nothing was refused. May be incomplete if memory is short.
  std::string note;
};

/// Requests real-time scheduling for the calling thread. Never throws; without SCHED_FIFO, the thread keeps its
/// ordinary priority.
RealtimeGranted enter_realtime(const RealtimeRequest& request) noexcept;

/// Lowers the priority of the calling thread, so that servo and picture come first. Errors are ignored.
void lower_priority() noexcept;

/// Why SCHED_FIFO is refused, and how to fix it; empty: it is granted. Tests this in a new thread.
std::string realtime_refusal();

/// Makes malloc keep up to 256 MiB of freed memory, except arrays of 32 MiB or more; otherwise the system clears every
/// page again. Call before other threads start; not in a library, because it affects the whole process.
void keep_freed_memory() noexcept;

/// Sets rounding to nearest and denormals on, whatever a library or the parent has set, so that the results of all
/// threads are bit-identical.
void use_ieee_arithmetic() noexcept;

/// Sleeps, then spins from 60 µs before the deadline. It does not always spin, because Linux would stop a SCHED_FIFO
/// thread for 50 ms of every second.
void sleep_until(long long deadline_ns) noexcept;

}  // namespace typodont
