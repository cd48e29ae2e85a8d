// Timing statistics of a loop: missed deadlines, jitter, slowest tick. The types are trivially copyable, because they
// are sent through the channel Latest.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "engine/base/clock.h"

namespace typodont {

/// A histogram of durations from 0.1 µs to 0.1 s. The upper edge of each bin is 9 % larger than that of the bin before
/// it: an octave (factor 2) has eight bins.
struct DurationHistogram {
  static constexpr int kPerOctave = 8;
  static constexpr int kBins = 20 * kPerOctave + 1;
  static constexpr double kSmallest = 100;  // ns, upper edge of the first bin
  std::array<std::uint32_t, kBins> counts{};

  static int bin(Nanos duration) noexcept {
    if (!(static_cast<double>(duration) > kSmallest)) return 0;
    const double octaves = std::log2(static_cast<double>(duration) / kSmallest);
    return std::min(kBins - 1, 1 + static_cast<int>(octaves * kPerOctave));
  }
  /// Returns the upper edge (ns) of bin i.
  static double upper_edge(int i) noexcept { return kSmallest * std::exp2(static_cast<double>(i) / kPerOctave); }

  void add(Nanos duration) noexcept { ++counts[static_cast<std::size_t>(bin(duration))]; }
  std::uint64_t total() const noexcept {
    std::uint64_t sum = 0;
    for (const std::uint32_t n : counts) sum += n;
    return sum;
  }
  /// Returns the upper edge (ns) of the bin in which the quantile q (0..1) lies. So the result is never smaller than
  /// the true quantile. Returns 0 if the histogram is empty.
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

/// Timing statistics of one loop. The loop's thread writes them. Trivially copyable.
struct LoopTiming {
  Nanos period = 1'000'000;  // ns, nominal period of the device
  std::uint64_t ticks = 0;
  std::uint64_t misses = 0;       // number of ticks that were not finished when the next sample was due
  std::uint64_t worst_index = 0;  // number of the tick that took the longest time
  Nanos worst_tick = 0;
  Nanos worst_jitter = 0;
  DurationHistogram jitter;  // ns, absolute difference between the period and the time from one wake-up to the next
  DurationHistogram work;    // ns, time from the device's sample (end of read()) to the force's output (end of write())
  Nanos last_woke = 0;

  /// Records one tick. `woke` is the time at which read() returned, and `done` is the time at which write() returned.
  /// Never allocates.
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

/// The real-time rights that the operating system granted to the servo loop, and the loop's timing. Servo thread →
/// recorder, renderer.
struct LoopReport {
  LoopTiming timing;
  bool fifo = false, pinned = false, memory_locked = false;
  // States which rights were refused and how to fix this. The text is zero-terminated, and empty if nothing was
  // refused.
  std::array<char, 320> note{};
  // The following members describe the safety layer of a device with motors.
  double heat = 0;        // present heat of the motor windings, as a fraction of the limit, 0..1
  double worst_heat = 0;  // largest heat of the motors so far, as a ratio to the limit
  // N, largest force that the motors may produce now without overheating; 0 if the device has no motors
  double bearable_force = 0;
  bool armed = false;        // true if the device may push the hand now
  std::uint32_t safety = 0;  // all SafetyEvent bits that were set since the start

  void say(std::string_view text) noexcept {
    const std::size_t n = std::min(text.size(), note.size() - 1);
    note = {};
    std::copy_n(text.begin(), n, note.begin());
  }
  std::string_view words() const noexcept { return {note.data()}; }
};

}  // namespace typodont
