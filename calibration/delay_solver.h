// Estimates the time offset between two recordings of the same motion, for instance by the haptic arm (A) and the
// tracker (B). Sign: a positive delay means that B lags A: p_B(t) = X_BA * p_A(t - delay). Times in seconds. Not for
// real-time threads.
#pragma once

#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

/// One recording. Times strictly increase. They may be irregular; samples may be missing or repeated (frozen sensor).
struct Stream {
  std::vector<double> t;  // s, times of the samples
  std::vector<dvec3> p;   // m, positions of the samples
};

struct DelayOptions {
  double max_delay = 2.0;  // s, search range in both directions; at most 40 % of the time that both streams cover
};

struct DelayResult {
  // s, delay; if the clocks have different rates, the delay at `reference_time` (the first time in both recordings)
  double delay = 0;
  // s, standard deviation of the delay. If the motion does not determine the delay, `sigma` is the standard deviation
  // of a number that is equally probable everywhere in the search range.
  double sigma = 0;
  bool ambiguous = false;
  std::string reason;              // the reason for an ambiguous result, as one sentence
  std::vector<double> candidates;  // s, all delays that explain the streams equally well, nearest to zero first
  bool rich = false;               // true if the motion determines the delay to 0.1 ms
  // relative difference of the rate of clock B from clock A (1e-6 = 1 ppm); 0 if not significant
  double skew = 0, skew_sigma = 0;
  double reference_time = 0;  // s, time at which `delay` is valid
  double delay_at_end = 0;    // s, delay at the last time in both recordings
  double noise = 0;           // m per axis, standard deviation of the difference between the streams
  // pose of the frame of stream A in the frame of stream B; its rotation is the identity unless the streams clearly
  // need a rotation
  Pose X_BA;
  bool rotated = false;  // true if a rotation was needed to align the streams
  int samples = 0;       // number of compared samples
  int lost_a = 0, lost_b = 0, frozen_a = 0, frozen_b = 0, rejected = 0;
};

/// Estimates the delay. Throws Error if a stream has fewer than 16 samples, if its times do not increase, or if the
/// streams do not overlap.
DelayResult estimate_delay(const Stream& a, const Stream& b, const DelayOptions& options = {});

}  // namespace typodont::calibration
