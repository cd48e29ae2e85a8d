// Records one motion with two devices: a haptic device, and a sensor that moves with its tool. Time stamps are arrival
// times on this computer's clock, as in a session.
#pragma once

#include <string>

#include "calibration/delay_solver.h"

namespace typodont {

struct DelayCaptureOptions {
  std::string hand;  // address of the haptic device, whose tool is moved
  std::string with;  // address of the second device: another hand, or opentrack:[ADDRESS:]PORT
  std::string pedal = "none";
  // Longest recording, s. The recording ends earlier when the delay is known to 0.1 ms.
  double seconds = 30;
};

struct DelayCapture {
  calibration::Stream a, b;
  calibration::DelayResult result;
};

/// Prints prompts on standard output, and an estimate every two seconds. Throws Error at set-up, RunFailure if a stream
/// of samples ends early.
DelayCapture capture_delay(const DelayCaptureOptions& options);

}  // namespace typodont
