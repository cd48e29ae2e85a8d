#include "engine/base/realtime.h"

#include <fmt/format.h>
#include <malloc.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cfenv>
#include <cstring>
#include <new>
#include <thread>

#include "engine/base/clock.h"

#ifdef __SSE2__
#include <immintrin.h>
#endif

namespace typodont {

RealtimeGranted enter_realtime(const RealtimeRequest& request) noexcept {
  RealtimeGranted granted;
  const auto say = [&](const auto& words) noexcept {
    try {
      granted.note += words();
    } catch (const std::bad_alloc&) {  // no memory for the message
    }
  };
  sched_param param{};
  param.sched_priority = request.priority;
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param); error == 0) {
    granted.fifo = true;
  } else {
    say([&] {
      return fmt::format("SCHED_FIFO refused ({}): allow it with 'rtprio 90' in /etc/security/limits.d; ",
                         std::strerror(error));
    });
  }
  int core = request.core;
  if (core == RealtimeRequest::kOwnCore) {
    core = -1;
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    if (granted.fifo && sched_getaffinity(0, sizeof allowed, &allowed) == 0 && CPU_COUNT(&allowed) >= 3) {
      for (int i = 0; i < CPU_SETSIZE; ++i) {
        if (CPU_ISSET(static_cast<unsigned>(i), &allowed)) core = i;
      }
    } else {
      say([&] {
        return granted.fifo ? "not pinned: fewer than three cores; "
                            : "not pinned: without SCHED_FIFO it would wait more; ";
      });
    }
  }
  if (core >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<unsigned>(core), &set);
    if (const int error = pthread_setaffinity_np(pthread_self(), sizeof set, &set); error == 0) {
      granted.pinned = true;
    } else {
      say([&] { return fmt::format("pinning to core {} refused ({}); ", core, std::strerror(error)); });
    }
  }
  if (request.lock_memory) {
    if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) {
      granted.memory_locked = true;
    } else {
      say([error = errno] {
        return fmt::format("locking memory refused ({}): allow it with 'memlock unlimited'; ", std::strerror(error));
      });
    }
  }
  return granted;
}

void lower_priority() noexcept {
  constexpr int kNice = 5;
  setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), kNice);
}

std::string realtime_refusal() {
  RealtimeGranted granted;
  std::thread([&] { granted = enter_realtime({.priority = 80, .core = -1, .lock_memory = false}); }).join();
  return granted.fifo ? std::string() : granted.note.substr(0, granted.note.rfind("; "));
}

void keep_freed_memory() noexcept {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
#endif
}

void use_ieee_arithmetic() noexcept {
  std::fesetround(FE_TONEAREST);
#ifdef __SSE2__
  _mm_setcsr(_mm_getcsr() & ~0x8040u);  // clears the flags flush-to-zero and denormals-are-zero
#endif
}

void sleep_until(long long deadline_ns) noexcept {
  constexpr long long kSpin = 60'000;  // ns; this long before the deadline, the thread spins instead of sleeping
  if (deadline_ns - now() > kSpin) {
    const long long wake = deadline_ns - kSpin;
    const timespec t{wake / kNanosPerSecond, wake % kNanosPerSecond};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr);
  }
  while (now() < deadline_ns) {
#ifdef __SSE2__
    _mm_pause();
#endif
  }
}

}  // namespace typodont
