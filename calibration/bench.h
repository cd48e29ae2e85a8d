// Work against precision: what each solver makes of so many touches in so much time, beside Eigen's and OpenCV's own on
// the same seeded data.
#pragma once

#include <string>
#include <vector>

namespace typodont::calibration {

struct BenchRow {
  std::string task;    // "register", "register 60 % outliers", "delay", …
  std::string method;  // "typodont", "Eigen umeyama", "OpenCV estimateAffine3D", "bound"
  int touches = 0;     // pairs, samples, captures or corners
  double error = 0;    // in error_unit, rms over the trials
  std::string error_unit;
  double time_us = 0;  // per solution, median; NaN for a bound
};

/// A few seconds; `quick` a fraction of one, with fewer trials.
std::vector<BenchRow> bench_rows(bool quick = false);

}  // namespace typodont::calibration
