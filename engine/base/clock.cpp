#include "engine/base/clock.h"

#include <ctime>

namespace typodont {

static Nanos read(clockid_t id) noexcept {
  timespec t{};
  clock_gettime(id, &t);
  return static_cast<Nanos>(t.tv_sec) * kNanosPerSecond + t.tv_nsec;
}

Nanos now() noexcept {
  return read(CLOCK_MONOTONIC);
}

Nanos thread_cpu_time() noexcept {
  return read(CLOCK_THREAD_CPUTIME_ID);
}

}  // namespace typodont
