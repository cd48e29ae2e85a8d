// Estimates the clock of a device from the times of its callbacks, which the scheduler delays.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/clock.h"
#include "engine/base/units.h"

namespace typodont::audio {

/// Delay-locked loop (Adriaensen 2005, "Using a DLL to filter time"). Audio thread only.
class ClockFilter {
 public:
  ClockFilter(double sample_rate, double bandwidth = 0.7) noexcept : rate_(sample_rate), bandwidth_(bandwidth) {}

  /// Returns the time at which the callback that came at `t` was due. Restarts if both times differ by more than four
  /// periods plus 20 ms.
  Nanos filtered(Nanos t, int samples) noexcept {
    const double nominal = samples / rate_ * 1e9;
    if (samples != samples_ || !running_ || std::abs(static_cast<double>(t - next_) - rest_) > 4 * nominal + 20e6) {
      samples_ = samples;
      running_ = true;
      period_ = nominal;
      next_ = t;
      rest_ = 0;
      // The loop's bandwidth is large at first, so that a late first callback is soon corrected.
      seen_ = 0;
    }
    const double error = static_cast<double>(t - next_) - rest_;
    const double seconds = samples / rate_;
    const double bandwidth = std::max(bandwidth_, 8 * bandwidth_ / (1 + static_cast<double>(seen_) * seconds * 4));
    ++seen_;
    const double w = 2 * kPi * std::min(bandwidth * seconds, 0.1);
    const Nanos now = next_;
    const double now_rest = rest_ + std::sqrt(2.0) * w * error;
    rest_ = now_rest + period_;
    period_ += w * w * error;
    const double whole = std::floor(rest_);
    next_ += static_cast<Nanos>(whole);
    rest_ -= whole;
    return now + static_cast<Nanos>(std::llround(now_rest));
  }

 private:
  double rate_, bandwidth_;
  int samples_ = 0;
  bool running_ = false;
  long long seen_ = 0;
  Nanos next_ = 0;     // ns, expected time of the next callback, integer part
  double rest_ = 0;    // ns, fractional part of next_
  double period_ = 0;  // ns, time between two callbacks
};

}  // namespace typodont::audio
