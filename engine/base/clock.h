// The monotonic clock of the whole program.
#pragma once

#include <cstdint>

namespace typodont {

using Nanos = std::int64_t;  // a time in ns since an arbitrary start

inline constexpr Nanos kNanosPerSecond = 1'000'000'000;

/// Time of CLOCK_MONOTONIC, ns. Any thread.
Nanos now() noexcept;

/// CPU time of the calling thread, ns; it does not depend on the machine's load.
Nanos thread_cpu_time() noexcept;

constexpr double to_seconds(Nanos t) {
  return static_cast<double>(t) * 1e-9;
}
constexpr Nanos from_seconds(double s) {
  return static_cast<Nanos>(s * 1e9 + (s < 0 ? -0.5 : 0.5));
}

}  // namespace typodont
