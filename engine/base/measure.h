// Measures the thread CPU time of a function for benchmarks. The function is repeated, because other programs on the
// machine disturb single measurements.
#pragma once

#include <sys/resource.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/base/clock.h"

namespace typodont {

/// Returns a quantile of the values. `fraction` (0..1) is 0.5 for the median. There must be at least one value.
inline double quantile(std::vector<double> values, double fraction) {
  const auto wanted = static_cast<std::size_t>(fraction * static_cast<double>(values.size()));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::min(wanted, values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Returns the CPU time in s of all threads of `who`: RUSAGE_SELF for this process, RUSAGE_CHILDREN for its child
/// processes that have ended.
inline double cpu_seconds(int who) {
  rusage used{};
  getrusage(who, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

/// Computes quantiles of any number of values with a limited amount of memory. It stores every value until it has kMost
/// values. After that, it stores only every second value, later every fourth value, and so on.
class EvenSample {
 public:
  void add(double value) {
    if (seen_++ % stride_ != 0) return;
    values_.push_back(value);
    if (values_.size() < kMost) return;
    for (std::size_t i = 0; i < kMost / 2; ++i) values_[i] = values_[2 * i];
    values_.resize(kMost / 2);
    stride_ *= 2;
  }
  /// Returns a quantile of the sampled values, or 0 if there are no values.
  double quantile(double fraction) const { return values_.empty() ? 0 : typodont::quantile(values_, fraction); }

  static constexpr std::size_t kMost = std::size_t{1} << 17;

 private:
  std::vector<double> values_;
  std::uint64_t seen_ = 0, stride_ = 1;
};

struct MeasuredTimes {
  double median = 0, slow = 0;  // ns; `slow` is the 90th percentile
};

/// Runs `work` in the calling thread `repeats` times (at least 1) and measures the thread CPU time of each run.
template <class F>
MeasuredTimes measure(int repeats, F&& work) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    const Nanos start = thread_cpu_time();
    work();
    times.push_back(static_cast<double>(thread_cpu_time() - start));
  }
  return {quantile(times, 0.5), quantile(times, 0.9)};
}

}  // namespace typodont
