// The monotonic clock that the whole program uses.
#pragma once

#include <cstdint>

namespace typodont {

using Nanos = std::int64_t;  // a time in ns since an arbitrary start

inline constexpr Nanos kNanosPerSecond = 1'000'000'000;

/// Returns the present time (ns) of the system clock CLOCK_MONOTONIC. Any thread.
Nanos now() noexcept;

/// Returns the CPU time (ns) that the calling thread has used so far. Unlike elapsed time, it does not depend on the
/// load of the machine.
Nanos thread_cpu_time() noexcept;

constexpr double to_seconds(Nanos t) {
  return static_cast<double>(t) * 1e-9;
}
constexpr Nanos from_seconds(double s) {
  return static_cast<Nanos>(s * 1e9 + (s < 0 ? -0.5 : 0.5));
}

}  // namespace typodont
