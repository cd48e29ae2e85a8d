// One monotonic clock for the whole program.
#pragma once

#include <cstdint>

namespace typodont {

using Nanos = std::int64_t;  // ns since an arbitrary start

inline constexpr Nanos kNanosPerSecond = 1'000'000'000;

/// Present time of CLOCK_MONOTONIC. Any thread.
Nanos now() noexcept;

/// CPU time consumed by the calling thread. It measures the cost of a tick independently of the machine's other load.
Nanos thread_cpu_time() noexcept;

constexpr double to_seconds(Nanos t) {
  return static_cast<double>(t) * 1e-9;
}
constexpr Nanos from_seconds(double s) {
  return static_cast<Nanos>(s * 1e9 + (s < 0 ? -0.5 : 0.5));
}

}  // namespace typodont
