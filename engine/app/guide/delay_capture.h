// Records one motion with two devices at the same time: the haptic device of the bench, and another sensor that moves
// together with this device. The time stamp of a sample is its arrival time on this computer's clock, as in a session.
#pragma once

#include <string>

#include "calibration/delay_solver.h"

namespace typodont {

struct DelayCaptureOptions {
  std::string hand;  // address of device A, which is a hand (a device that can move the tool)
  std::string with;  // address of device B: another hand, or opentrack:[ADDRESS:]PORT
  std::string pedal = "none";
  // s, largest duration; the capture ends earlier if the delay is known with an accuracy of 0.1 ms
  double seconds = 30;
};

struct DelayCapture {
  calibration::Stream a, b;
  calibration::DelayResult result;
};

/// Measures the delay between the two devices. Prints prompts on standard output, and the present estimate every two
/// seconds. Throws Error at set-up, and RunFailure if a stream ends too early.
DelayCapture capture_delay(const DelayCaptureOptions& options);

}  // namespace typodont
