// What the calibration hands to the display and to the haptic device.
#pragma once

#include <array>

#include "engine/base/pose.h"

namespace typodont {

/// X_WH with its uncertainty. Covariance of (rotation vector in rad, translation in m), row-major 6×6.
struct Registration {
  Pose X_WH;
  std::array<double, 36> covariance{};
  double sigma = 0;  // m, noise of one touched point, per axis
};

}  // namespace typodont
