// Time offset between two recordings of one motion. Positive: B lags A, p_B(t) = X_BA * p_A(t - delay). Seconds. Not
// for real time.
#pragma once

#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

/// Times strictly increase, may be irregular; samples may be missing or frozen.
struct Stream {
  std::vector<double> t;  // s, times of the samples
  std::vector<dvec3> p;   // m, positions of the samples
};

struct DelayOptions {
  double max_delay = 2.0;  // s, both ways; at most 40 % of the shared time
};

struct DelayResult {
  // s; with different clock rates, at `reference_time` (the first shared time)
  double delay = 0;
  // s; undetermined: that of a uniform number in the search range
  double sigma = 0;
  bool ambiguous = false;
  std::string reason;              // the reason for an ambiguous result, as one sentence
  std::vector<double> candidates;  // s, equally good delays, nearest to zero first
  bool rich = false;               // true if the motion determines the delay to 0.1 ms
  // relative, 1e-6 = 1 ppm; 0 if not significant
  double skew = 0, skew_sigma = 0;
  double reference_time = 0;  // s, time at which `delay` is valid
  double delay_at_end = 0;    // s, delay at the last time in both recordings
  double noise = 0;           // m per axis, difference of the streams
  // no rotation unless the streams clearly need one
  Pose X_BA;
  bool rotated = false;  // true if a rotation was needed to align the streams
  int samples = 0;       // number of compared samples
  int lost_a = 0, lost_b = 0, frozen_a = 0, frozen_b = 0, rejected = 0;
};

/// Throws Error below 16 samples, for times that do not increase, or without overlap.
DelayResult estimate_delay(const Stream& a, const Stream& b, const DelayOptions& options = {});

}  // namespace typodont::calibration
