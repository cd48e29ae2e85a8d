// What all benchmark programs share. A program defines add_cases(). Each case is a benchmark of google-benchmark that
// runs once; its results are the median of its times and named counters, whose names end with their unit.
#pragma once

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "engine/base/clock.h"
#include "engine/base/measure.h"

namespace typodont::bench {

/// Adds the cases of this program.
void add_cases();

/// True with the option `--smoke`: each case has a tiny workload, and its times mean nothing.
bool smoke();

using Work = std::function<void(benchmark::State&)>;
/// Adds a case, which runs once.
void add(const std::string& name, Work work);

/// Reports a claim that does not hold; the program then exits with status 1.
void require(bool holds, const std::string& claim);
/// The same for a claim about times, which is not checked in a smoke run.
inline void require_time(bool holds, const std::string& claim) {
  require(smoke() || holds, claim);
}

/// Number of equal runs. The shortest time of a tick over all runs is its time without interrupts.
inline int runs() {
  return smoke() ? 1 : 3;
}
/// `run` returns the times of its ticks. Returns the shortest time of each tick over all runs.
template <class Run>
std::vector<double> least_of(Run&& run) {
  std::vector<double> least = run();
  for (int i = 1; i < runs(); ++i) {
    const std::vector<double> more = run();
    for (std::size_t k = 0; k < least.size(); ++k) least[k] = std::min(least[k], more[k]);
  }
  return least;
}

/// Part of a measured time that two readings of the clock take themselves, ns. A short time is stated without it.
inline double clock_ns() {
  static const double median = measure(10'000, [] {}).median;
  return median;
}

/// Returns the thread CPU time of one call, ns: the median over batches of calls.
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

inline void set_time(benchmark::State& state, double ns) {
  state.SetIterationTime(1e-9 * ns);
}
/// Sets the time of the case to the median, and a counter to the 99.9 % quantile. `ns`: times of equal work.
inline void set_times(benchmark::State& state, const std::vector<double>& ns) {
  set_time(state, quantile(ns, 0.5));
  state.counters["slow_ns"] = quantile(ns, 0.999);
}

}  // namespace typodont::bench
