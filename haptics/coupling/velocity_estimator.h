// Estimates the velocity of the hand from quantised positions: with low noise at rest, fast response in motion, and
// known lag. End-fit FOAW (first-order adaptive windowing: Janabi-Sharifi, Hayward & Chen 2000, "Discrete-time adaptive
// windowing for velocity estimation"), changed: (1) an interval of allowed slopes makes a tick O(window); (2) all axes
// use the shortest window; (3) stored samples are at least kSpacing apart.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/clock.h"
#include "engine/base/pose.h"

namespace typodont::haptics {

struct VelocityEstimate {
  dvec3 v{0};      // m/s, velocity of the hand
  double lag = 0;  // s, half the length of the window
};

class VelocityEstimator {
 public:
  /// `noise`: m, half the peak-to-peak noise; for an encoder, one step. `axes`: only the first `axes` axes move.
  explicit VelocityEstimator(double noise, int axes = 3) : noise_(noise), axes_(axes) {}

  /// Adds a position and returns the velocity. Servo thread only; never allocates. A time that does not increase
  /// restarts the estimator.
  VelocityEstimate add(Nanos t, const dvec3& p) noexcept {
    if (count_ > 0 && t <= newest_.t) count_ = 0;
    const bool first = count_ == 0;
    newest_ = {t, p};
    VelocityEstimate estimate;
    if (!first) {
      std::size_t window = count_;
      for (int axis = 0; axis < axes_; ++axis) window = std::min(window, longest(axis, window));
      const Sample& start = back(window);
      const double span = to_seconds(t - start.t);
      estimate = {(p - start.p) / span, span / 2};
    }
    if (first || t - back(1).t >= kSpacing) {
      head_ = (head_ + 1) % kPast;
      ring_[head_] = newest_;
      count_ = std::min(count_ + 1, kPast);
    }
    return estimate;
  }
  void reset() noexcept { count_ = 0; }

  static constexpr std::size_t kWindow = 48;  // samples in the window; 47 ms at 1 kHz
  // ns, smallest time between samples; below 1 ms, so that a loop of 1 kHz with jitter stores every sample
  static constexpr Nanos kSpacing = 750'000;

 private:
  static constexpr std::size_t kPast = kWindow - 1;
  struct Sample {
    Nanos t = 0;
    dvec3 p{0};
  };
  const Sample& back(std::size_t n) const noexcept { return ring_[(head_ + kPast + 1 - n) % kPast]; }

  std::size_t longest(int axis, std::size_t most) const noexcept {
    // Slopes (m/s) of lines through the newest sample from which no examined sample deviates by more than the noise.
    double low = -1e300, high = 1e300;
    std::size_t best = 1;
    for (std::size_t n = 1; n <= most; ++n) {
      const double dt = to_seconds(newest_.t - back(n).t);
      const double dx = newest_.p[axis] - back(n).p[axis];
      const double slope = dx / dt;
      if (slope >= low && slope <= high) best = n;
      low = std::max(low, (dx - noise_) / dt);
      high = std::min(high, (dx + noise_) / dt);
      if (low > high) break;
    }
    return best;
  }

  double noise_;
  int axes_;
  Sample newest_;
  std::array<Sample, kPast> ring_{};
  std::size_t head_ = 0, count_ = 0;
};

}  // namespace typodont::haptics
