// Finds the time offset between two recordings of the same motion. Positive if B lags A: p_B(t) = X_BA * p_A(t -
// delay). Times in s. Not for real time.
#pragma once

#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

/// Positions over time. Times must strictly increase, but may be irregular; samples may be missing or frozen.
struct Stream {
  std::vector<double> t;  // s, times of the samples
  std::vector<dvec3> p;   // m, positions of the samples
};

struct DelayOptions {
  double max_delay = 2.0;  // s; delays from -max_delay to max_delay are tried, up to 40 % of the common duration
};

struct DelayResult {
  // Delay, s. If the clocks have different rates, it is valid at `reference_time`, the first time in both recordings.
  double delay = 0;
  // Standard deviation, s; if the delay is not determined, that of a uniform distribution over the searched range.
  double sigma = 0;
  bool ambiguous = false;
  std::string reason;              // the reason for an ambiguous result, as one sentence
  std::vector<double> candidates;  // s, equally probable delays, the one nearest to zero first
  bool rich = false;               // true if the motion determines the delay to 0.1 ms
  // Relative difference of the clock rates (1e-6 = 1 ppm) and its standard deviation; 0 if not significant.
  double skew = 0, skew_sigma = 0;
  double reference_time = 0;  // s, time at which `delay` is valid
  double delay_at_end = 0;    // s, delay at the last time in both recordings
  double noise = 0;           // m per axis, standard deviation of the aligned streams' difference
  // Pose of stream A in B; without rotation, unless the streams clearly need one.
  Pose X_BA;
  bool rotated = false;  // true if a rotation was needed to align the streams
  int samples = 0;       // number of samples that were compared
  int lost_a = 0, lost_b = 0, frozen_a = 0, frozen_b = 0, rejected = 0;
};

/// Estimates the delay. Throws Error for fewer than 16 samples, times that do not increase, or recordings that do not
/// overlap in time.
DelayResult estimate_delay(const Stream& a, const Stream& b, const DelayOptions& options = {});

}  // namespace typodont::calibration
