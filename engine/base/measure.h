// How long a piece of work takes, for benches: thread CPU time, repeated, because machines are shared and noisy.
#pragma once

#include <algorithm>
#include <vector>

#include "engine/base/clock.h"

namespace typodont {

struct MeasuredTimes {
  double median = 0, slow = 0;  // ns; slow: the 90th percentile
};

/// Calling thread. `repeats` at least 1.
template <class F>
MeasuredTimes measure(int repeats, F&& work) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    const Nanos start = thread_cpu_time();
    work();
    times.push_back(static_cast<double>(thread_cpu_time() - start));
  }
  std::sort(times.begin(), times.end());
  return {times[times.size() / 2], times[times.size() * 9 / 10]};
}

}  // namespace typodont
