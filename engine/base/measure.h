// Measures the CPU time of a function for benchmarks. Repeats it, because other programs disturb the measurement.
#pragma once

#include <sys/resource.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/base/clock.h"
#include "engine/base/quantile.h"

namespace typodont {

/// CPU time of all threads, s. `who`: RUSAGE_SELF, or RUSAGE_CHILDREN for child processes that have ended.
inline double cpu_seconds(int who) {
  rusage used{};
  getrusage(who, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

/// Computes quantiles in limited memory: after kMost values it keeps only every second value, then every fourth, and so
/// on.
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
  /// Quantile of the values; 0 if there are none.
  double quantile(double fraction) const { return values_.empty() ? 0 : typodont::quantile(values_, fraction); }

  static constexpr std::size_t kMost = std::size_t{1} << 17;

 private:
  std::vector<double> values_;
  std::uint64_t seen_ = 0, stride_ = 1;
};

struct MeasuredTimes {
  double median = 0, slow = 0;  // ns; `slow` is the 90th percentile
};

/// Runs `work` `repeats` times (at least 1), in this thread.
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
