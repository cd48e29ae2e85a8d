// Preloaded into a program under test: adds the offsets in leaping_clock.h's file to the machine's clocks. A wait until
// a time of such a clock ends as it would without the offset.
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <cstdlib>

#include "tests/support/emulation/leaping_clock.h"

namespace {

using typodont::kNanosPerSecond;
using typodont::Nanos;
using typodont::test::ClockOffsets;

ClockOffsets* offsets() {
  static ClockOffsets* const mapped = [] {
    static ClockOffsets none;
    const char* file = std::getenv("TYPODONT_CLOCK_FILE");
    const int fd = file ? ::open(file, O_RDWR | O_CLOEXEC) : -1;
    if (fd < 0) return &none;
    void* memory = ::mmap(nullptr, sizeof(ClockOffsets), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    ::close(fd);
    return memory == MAP_FAILED ? &none : static_cast<ClockOffsets*>(memory);
  }();
  return mapped;
}

Nanos offset_of(clockid_t clock) {
  if (clock == CLOCK_MONOTONIC) return offsets()->monotonic.load();
  return clock == CLOCK_REALTIME ? offsets()->wall.load() : 0;
}

timespec shifted(const timespec& t, Nanos by) {
  const Nanos sum = Nanos{t.tv_sec} * kNanosPerSecond + t.tv_nsec + by;
  const Nanos whole = sum >= 0 ? sum / kNanosPerSecond : 0;
  return {whole, sum >= 0 ? sum % kNanosPerSecond : 0};
}

template <class F>
F* real(const char* name) {
  return reinterpret_cast<F*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* out) noexcept {
  static auto* const machine = real<int(clockid_t, timespec*)>("clock_gettime");
  const int status = machine(clock, out);
  if (status == 0) *out = shifted(*out, offset_of(clock));
  return status;
}

int clock_nanosleep(clockid_t clock, int flags, const timespec* t, timespec* left) {
  static auto* const machine = real<int(clockid_t, int, const timespec*, timespec*)>("clock_nanosleep");
  const timespec until = flags & TIMER_ABSTIME ? shifted(*t, -offset_of(clock)) : *t;
  return machine(clock, flags, &until, left);
}

int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock, const timespec* t) {
  static auto* const machine =
      real<int(pthread_cond_t*, pthread_mutex_t*, clockid_t, const timespec*)>("pthread_cond_clockwait");
  const timespec until = shifted(*t, -offset_of(clock));
  return machine(condition, mutex, clock, &until);
}

}  // extern "C"
