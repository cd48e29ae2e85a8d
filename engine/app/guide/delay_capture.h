// Records one motion live with two devices: the haptic device of the bench, and another sensor that moves with it. Each
// sample gets the time of its arrival on this computer's clock, like the samples of a session.
#pragma once

#include <string>

#include "calibration/delay_solver.h"

namespace typodont {

struct DelayCaptureOptions {
  std::string hand;  // A: the address of a hand
  std::string with;  // B: another hand's address, or opentrack:[ADDRESS:]PORT
  std::string pedal = "none";
  double seconds = 30;  // s, limit of the duration; the capture ends earlier if the delay is known to 0.1 ms
};

struct DelayCapture {
  calibration::Stream a, b;
  calibration::DelayResult result;
};

/// Captures the delay. Prints prompts on standard output and reports the present estimate every two seconds. Throws
/// Error at set-up, and RunFailure if a stream ends too early.
DelayCapture capture_delay(const DelayCaptureOptions& options);

}  // namespace typodont
