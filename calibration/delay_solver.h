// The time offset between two recordings of one motion, for instance the haptic arm (A) and the tracker (B).
// Sign: a positive delay means that B lags A: p_B(t) = X_BA * p_A(t - delay). Seconds; any thread; set-up time.
#pragma once

#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

/// One recording. Times strictly increase; they need not be regular, and samples may be missing or frozen.
struct Stream {
  std::vector<double> t;  // s
  std::vector<dvec3> p;   // m
};

struct DelayOptions {
  double max_delay = 2.0;  // s, searched both ways; at most 40 % of what the streams share
};

struct DelayResult {
  double delay = 0;  // s, at `reference_time` (the first common moment) when the clocks run apart, else everywhere
  double sigma = 0;  // s; the width of the search when the motion does not determine it
  bool ambiguous = false;
  std::string reason;               // why it is ambiguous, one sentence
  std::vector<double> candidates;   // s, every delay that explains the streams as well, nearest to zero first
  bool rich = false;                // the motion determines the delay to 0.1 ms
  double skew = 0, skew_sigma = 0;  // how much faster B's clock runs (1e-6 = 1 ppm); 0 when not significant
  double reference_time = 0;        // s
  double delay_at_end = 0;          // s, at the last common moment
  double noise = 0;                 // m per axis, of the difference of the two streams
  Pose X_BA;                        // the rotation is the identity unless the streams clearly need another
  bool rotated = false;             // whether they do
  int samples = 0;                  // compared
  int lost_a = 0, lost_b = 0, frozen_a = 0, frozen_b = 0, rejected = 0;
};

/// Throws Error when a stream has fewer than 16 samples, its times do not increase, or the two do not overlap.
DelayResult estimate_delay(const Stream& a, const Stream& b, const DelayOptions& options = {});

}  // namespace typodont::calibration
