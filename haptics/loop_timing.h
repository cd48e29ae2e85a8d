// How well a loop keeps its time: missed deadlines, jitter, worst tick. Plain data, so that it travels through Latest.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "engine/base/clock.h"

namespace typodont::haptics {

/// Counts of durations in bins of equal ratio, eight to an octave (9 % wide), from 0.1 µs to 0.1 s.
struct DurationHistogram {
  static constexpr int kPerOctave = 8;
  static constexpr int kBins = 20 * kPerOctave + 1;
  static constexpr double kSmallest = 100;  // ns
  std::array<std::uint32_t, kBins> counts{};

  static int bin(Nanos duration) noexcept {
    if (!(static_cast<double>(duration) > kSmallest)) return 0;
    const double octaves = std::log2(static_cast<double>(duration) / kSmallest);
    return std::min(kBins - 1, 1 + static_cast<int>(octaves * kPerOctave));
  }
  /// ns, where bin i ends.
  static double upper_edge(int i) noexcept { return kSmallest * std::exp2(static_cast<double>(i) / kPerOctave); }

  void add(Nanos duration) noexcept { ++counts[static_cast<std::size_t>(bin(duration))]; }
  std::uint64_t total() const noexcept {
    std::uint64_t sum = 0;
    for (const std::uint32_t n : counts) sum += n;
    return sum;
  }
  /// ns; the upper edge of the bin that holds the q-quantile, so never too kind. 0 while empty.
  double quantile(double q) const noexcept {
    const double wanted = q * static_cast<double>(total());
    double sum = 0;
    for (int i = 0; i < kBins; ++i) {
      sum += counts[static_cast<std::size_t>(i)];
      if (sum > 0 && sum >= wanted) return upper_edge(i);
    }
    return 0;
  }
};

/// The loop's thread records; trivially copyable.
struct LoopTiming {
  Nanos period = 1'000'000;  // nominal, of the device
  std::uint64_t ticks = 0;
  std::uint64_t misses = 0;       // ticks whose work was not done when the next sample was due
  std::uint64_t worst_index = 0;  // the tick that took longest
  Nanos worst_tick = 0;
  Nanos worst_jitter = 0;
  DurationHistogram jitter;  // |time between two wake-ups - period|
  DurationHistogram work;    // from the device's sample to the force written
  Nanos last_woke = 0;

  /// One tick: when read() returned, when write() had returned. Never allocates.
  void record(Nanos woke, Nanos done) noexcept {
    const Nanos took = done - woke;
    if (ticks > 0) {
      const Nanos off = std::abs(woke - last_woke - period);
      jitter.add(off);
      worst_jitter = std::max(worst_jitter, off);
    }
    work.add(took);
    if (took > worst_tick) {
      worst_tick = took;
      worst_index = ticks;
    }
    if (took > period) ++misses;
    last_woke = woke;
    ++ticks;
  }
};

}  // namespace typodont::haptics
