// Timing statistics of a loop: missed deadlines, jitter, slowest tick. Plain data, so that it can pass through Latest.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "engine/base/clock.h"

namespace typodont {

/// Counts of durations in bins of equal ratio, eight to an octave (9 % wide), from 0.1 µs to 0.1 s.
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
  /// Upper edge of bin i in ns.
  static double upper_edge(int i) noexcept { return kSmallest * std::exp2(static_cast<double>(i) / kPerOctave); }

  void add(Nanos duration) noexcept { ++counts[static_cast<std::size_t>(bin(duration))]; }
  std::uint64_t total() const noexcept {
    std::uint64_t sum = 0;
    for (const std::uint32_t n : counts) sum += n;
    return sum;
  }
  /// Upper edge, in ns, of the bin that contains the q-quantile; so the result is never below the true quantile. 0 if
  /// there are no counts.
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

/// Statistics that the loop's thread records. Trivially copyable.
struct LoopTiming {
  Nanos period = 1'000'000;  // nominal period of the device
  std::uint64_t ticks = 0;
  std::uint64_t misses = 0;       // number of ticks whose work was not finished when the next sample was due
  std::uint64_t worst_index = 0;  // number of the tick that took longest
  Nanos worst_tick = 0;
  Nanos worst_jitter = 0;
  DurationHistogram jitter;  // |time between two wake-ups - period|
  DurationHistogram work;    // time from the device's sample to the written force
  Nanos last_woke = 0;

  /// Records one tick: `woke` is when read() returned, `done` is when write() returned. Never allocates.
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
/// recorder, render.
struct LoopReport {
  LoopTiming timing;
  bool fifo = false, pinned = false, memory_locked = false;
  std::array<char, 320> note{};  // states what was refused and how to fix it; zero-terminated; empty: no refusal
  // The next fields describe the safety layer of a device with motors.
  double heat = 0;            // present heat of the motor windings, as a fraction of the limit, 0..1
  double worst_heat = 0;      // largest `heat` so far
  double bearable_force = 0;  // N, largest force that the motors may produce now; 0: a device without motors
  bool armed = false;         // true if a force may reach the hand
  std::uint32_t safety = 0;   // all SafetyEvent bits since the start

  void say(std::string_view text) noexcept {
    const std::size_t n = std::min(text.size(), note.size() - 1);
    note = {};
    std::copy_n(text.begin(), n, note.begin());
  }
  std::string_view words() const noexcept { return {note.data()}; }
};

}  // namespace typodont
