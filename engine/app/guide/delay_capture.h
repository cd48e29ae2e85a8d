// Two recordings of one motion, live: what the bench feels with and what else follows the same hand. Both are stamped
// with this computer's clock when their sample arrives, as a session would see them.
#pragma once

#include <string>

#include "calibration/delay_solver.h"

namespace typodont {

struct DelayCaptureOptions {
  std::string hand;  // A: the address of a hand
  std::string with;  // B: another hand's address, or opentrack:[ADDRESS:]PORT
  std::string pedal = "none";
  double seconds = 30;  // at most; sooner where the delay is known to 0.1 ms
};

struct DelayCapture {
  calibration::Stream a, b;
  calibration::DelayResult result;
};

/// Prompts on standard output, and says every two seconds what is known. Throws Error at set-up, RunFailure when a
/// stream ends before it says anything.
DelayCapture capture_delay(const DelayCaptureOptions& options);

}  // namespace typodont
