// The result of the registration between the display and the haptic device.
#pragma once

#include <array>

#include "engine/base/pose.h"

namespace typodont {

/// The pose X_WH of the haptic base in the workbench frame W, and its uncertainty: the 6×6 covariance (row-major) of
/// the rotation vector in rad and the translation in m.
struct Registration {
  Pose X_WH;
  std::array<double, 36> covariance{};
  double sigma = 0;  // m, standard deviation of the error of one touched point, along each axis
};

}  // namespace typodont
