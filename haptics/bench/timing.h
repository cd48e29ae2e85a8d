// Measures calls and ticks that are too short for a single clock reading.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "engine/base/clock.h"
#include "engine/base/measure.h"

namespace typodont::haptics::bench {

/// CPU time of one call, ns. The median over `repeats` batches of calls, because one call is too short for the clock.
template <class F>
double batch_ns(int repeats, int batch, F&& work) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    const Nanos start = thread_cpu_time();
    for (int k = 0; k < batch; ++k) work(k);
    times.push_back(static_cast<double>(thread_cpu_time() - start) / batch);
  }
  return quantile(times, 0.5);
}

/// Time that two readings of the clock take, ns. It is subtracted from every measured time.
inline double clock_ns() {
  std::vector<double> times;
  for (int i = 0; i < 1001; ++i) {
    const Nanos start = thread_cpu_time();
    times.push_back(static_cast<double>(thread_cpu_time() - start));
  }
  return quantile(times, 0.5);
}

/// Number of equal runs. The minimum of each tick over the runs is its time without interrupts.
inline constexpr int kRuns = 3;
template <class Run>  // `run` returns the times of its ticks, ns
std::vector<double> least_of(Run&& run) {
  const double clock = clock_ns();
  std::vector<double> least = run();
  for (int i = 1; i < kRuns; ++i) {
    const std::vector<double> more = run();
    for (std::size_t k = 0; k < least.size(); ++k) least[k] = std::min(least[k], more[k]);
  }
  for (double& time : least) time = std::max(time - clock, 0.0);
  return least;
}

}  // namespace typodont::haptics::bench
