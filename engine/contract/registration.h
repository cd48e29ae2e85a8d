// Registration between display and haptic device.
#pragma once

#include <array>

#include "engine/base/pose.h"

namespace typodont {

/// Pose X_WH of the haptic base, and its uncertainty: the 6×6 covariance (row-major) of rotation vector (rad) and
/// translation (m).
struct Registration {
  Pose X_WH;
  std::array<double, 36> covariance{};
  double sigma = 0;  // m, standard deviation of a touched point, per axis
};

}  // namespace typodont
