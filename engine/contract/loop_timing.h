// Timing of a real-time loop: missed deadlines, jitter, slowest tick. Trivially copyable, for the channel Latest.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "engine/base/clock.h"

namespace typodont {

/// Histogram of durations from 0.1 µs to 0.1 s, eight bins per octave: an upper edge is 9 % above the previous edge.
struct DurationHistogram {
  static constexpr int kPerOctave = 8;
  static constexpr int kBins = 20 * kPerOctave + 1;
  static constexpr double kMin = 100;  // ns, upper edge of the first bin
  std::array<std::uint32_t, kBins> counts{};

  static int bin(Nanos duration) noexcept {
    if (!(static_cast<double>(duration) > kMin)) return 0;
    const double octaves = std::log2(static_cast<double>(duration) / kMin);
    return std::min(kBins - 1, 1 + static_cast<int>(octaves * kPerOctave));
  }
  /// Upper edge of bin i, ns.
  static double upper_edge(int i) noexcept { return kMin * std::exp2(static_cast<double>(i) / kPerOctave); }

  void add(Nanos duration) noexcept { ++counts[static_cast<std::size_t>(bin(duration))]; }
  std::uint64_t total() const noexcept {
    std::uint64_t sum = 0;
    for (const std::uint32_t n : counts) sum += n;
    return sum;
  }
  /// Quantile q (0 to 1) of the durations, ns: the upper edge of its bin, so never below the true value. 0 if empty.
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

/// Loop statistics, written by the loop's thread. Trivially copyable.
struct LoopTiming {
  Nanos period = 1'000'000;  // ns, nominal period of the device
  std::uint64_t ticks = 0;
  std::uint64_t misses = 0;       // number of ticks not finished when the next sample was due
  std::uint64_t worst_index = 0;  // index of the slowest tick
  Nanos worst_tick = 0;
  Nanos worst_jitter = 0;
  DurationHistogram jitter;  // ns, |period − time between two wake-ups|
  DurationHistogram work;    // ns, from the end of read() to that of write()
  Nanos last_woke = 0;

  /// Adds a tick. `woke`: time at which read() returned; `done`: time at which write() returned. Never allocates.
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

/// Scheduling rights that the servo loop got, and its timing. Servo thread → recorder, renderer.
struct LoopReport {
  LoopTiming timing;
  bool fifo = false, pinned = false, memory_locked = false;
  // Text, zero-terminated: which permission was refused and how to fix this. Empty: none was refused.
  std::array<char, 320> note{};
  // The following members are the state of the safety layer of a device with motors.
  double heat = 0;        // motor windings' heat, as a fraction of the limit
  double worst_heat = 0;  // largest heat so far, as a fraction of the limit
  // Largest lasting force that does not overheat the motors, N. 0: the device has no motors.
  double bearable_force = 0;
  bool armed = false;        // true: the device may push the hand now
  std::uint32_t safety = 0;  // all SafetyEvents so far, as bits

  void say(std::string_view text) noexcept {
    const std::size_t n = std::min(text.size(), note.size() - 1);
    note = {};
    std::copy_n(text.begin(), n, note.begin());
  }
  std::string_view words() const noexcept { return {note.data()}; }
};

}  // namespace typodont
