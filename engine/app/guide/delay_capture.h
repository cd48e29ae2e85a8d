// One motion recorded by the bench's haptic device and a sensor that moves with it. Time stamps are arrival times on
// this computer's clock, as in a session.
#pragma once

#include <string>

#include "calibration/delay_solver.h"

namespace typodont {

struct DelayCaptureOptions {
  std::string hand;  // a device that can move the tool
  std::string with;  // address of device B: another hand, or opentrack:[ADDRESS:]PORT
  std::string pedal = "none";
  // s at most; ends earlier at 0.1 ms accuracy
  double seconds = 30;
};

struct DelayCapture {
  calibration::Stream a, b;
  calibration::DelayResult result;
};

/// Prompts on standard output, an estimate every two seconds. Throws Error at set-up, RunFailure if a stream ends
/// early.
DelayCapture capture_delay(const DelayCaptureOptions& options);

}  // namespace typodont
