// The error of an estimated pose in the form of the solvers' covariances.
#pragma once

#include <Eigen/Dense>

#include "engine/base/pose.h"

namespace typodont::test {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

/// Rotation vector (rad) and translation (m) from `truth` to `found`; for small errors.
inline Vector6 error_of(const Pose& found, const Pose& truth) {
  const dquat d = found.R * glm::conjugate(truth.R);
  const dvec3 axis = (d.w < 0 ? -2.0 : 2.0) * dvec3(d.x, d.y, d.z), t = found.p - truth.p;
  Vector6 error;
  error << axis.x, axis.y, axis.z, t.x, t.y, t.z;
  return error;
}

}  // namespace typodont::test
