// Real-time settings that a thread requests from the operating system before it enters a real-time loop.
#pragma once

#include <string>

namespace typodont {

struct RealtimeRequest {
  int priority = 80;  // SCHED_FIFO priority, 1 to 99
  static constexpr int kOwnCore = -2;
  // Number of the processor core to which the thread is pinned. -1: the thread is not pinned. kOwnCore: the thread is
  // pinned to the last core of this process, but only if the process has at least three cores and SCHED_FIFO was
  // granted. (Without SCHED_FIFO a thread runs better if the scheduler can move it to another core.)
  int core = -1;
  bool lock_memory = true;  // true: mlockall() keeps all pages in memory
};

struct RealtimeGranted {
  bool fifo = false;
  bool pinned = false;
  bool memory_locked = false;
  // States which requests were refused and how to fix this. Empty if everything was granted. If memory is short, the
  // text may be incomplete.
  std::string note;
};

/// Requests real-time settings for the calling thread. Never throws: the result states what was refused. If SCHED_FIFO
/// was refused, the loop runs at ordinary priority.
RealtimeGranted enter_realtime(const RealtimeRequest& request) noexcept;

/// States why the system refuses SCHED_FIFO to this process and how to fix this. The text is empty if the system grants
/// SCHED_FIFO. The function makes the request in a separate thread.
std::string realtime_refusal();

/// Lets the allocator keep up to 256 MiB of freed memory for the next allocations, except arrays of 32 MiB or more,
/// which are returned to the system at once. By default, the allocator also returns smaller arrays, and the system must
/// clear each page of memory before the program can use it again. Call this function before other threads start. A
/// library must not call it, because it affects the whole process.
void keep_freed_memory() noexcept;

/// Makes the processor treat denormals as zero in the calling thread. Otherwise a decaying filter would become slow
/// when its values become denormal.
void flush_denormals() noexcept;

/// Makes the calling thread round to nearest and compute with denormals, even if a library or the parent thread has set
/// other modes. Code that must give the same bits on every thread calls this function first.
void use_ieee_arithmetic() noexcept;

/// Sleeps until 60 µs before the deadline, then spins until the deadline. If a SCHED_FIFO thread spun all the time,
/// Linux would stop it for 50 ms of every second.
void sleep_until(long long deadline_ns) noexcept;

}  // namespace typodont
