// Measures the time of calls and ticks that are too short to be measured with two readings of the clock.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "engine/base/clock.h"
#include "engine/base/measure.h"

namespace typodont::haptics::bench {

/// Returns the CPU time of one call in ns: the median over `repeats` batches of calls.
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

/// Returns the time between two successive readings of the clock, ns. It is subtracted from measured times.
inline double clock_ns() {
  std::vector<double> times;
  for (int i = 0; i < 1001; ++i) {
    const Nanos start = thread_cpu_time();
    times.push_back(static_cast<double>(thread_cpu_time() - start));
  }
  return quantile(times, 0.5);
}

/// Number of runs with the same work. The shortest time of a tick over all runs is its time without interrupts.
inline constexpr int kRuns = 3;
/// `run` returns the times of its ticks in ns, or the mean times of ticks in batches of `batch` ticks. The clock was
/// read once before and once after each batch.
template <class Run>
std::vector<double> least_of(Run&& run, int batch = 1) {
  const double clock = clock_ns() / batch;
  std::vector<double> least = run();
  for (int i = 1; i < kRuns; ++i) {
    const std::vector<double> more = run();
    for (std::size_t k = 0; k < least.size(); ++k) least[k] = std::min(least[k], more[k]);
  }
  for (double& time : least) time = std::max(time - clock, 0.0);
  return least;
}

}  // namespace typodont::haptics::bench
