// Result of the registration between the display and the haptic device.
#pragma once

#include <array>

#include "engine/base/pose.h"

namespace typodont {

/// X_WH and its uncertainty: the covariance of (rotation vector in rad, translation in m), row-major 6×6.
struct Registration {
  Pose X_WH;
  std::array<double, 36> covariance{};
  double sigma = 0;  // m, standard deviation of one touched point, per axis
};

}  // namespace typodont
