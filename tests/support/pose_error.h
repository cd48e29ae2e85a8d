// The error of an estimated pose, in the same form as in the covariances of the solvers.
#pragma once

#include <Eigen/Dense>

#include "engine/base/pose.h"

namespace typodont::test {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

/// Returns the rotation vector (rad) and the translation (m) from `truth` to `found`. Valid for small errors.
inline Vector6 error_of(const Pose& found, const Pose& truth) {
  const dquat d = found.R * glm::conjugate(truth.R);
  const dvec3 axis = (d.w < 0 ? -2.0 : 2.0) * dvec3(d.x, d.y, d.z), t = found.p - truth.p;
  Vector6 error;
  error << axis.x, axis.y, axis.z, t.x, t.y, t.z;
  return error;
}

}  // namespace typodont::test
