#include "calibration/eyes_solver.h"

#include <algorithm>
#include <cmath>

#include "calibration/solver/least_squares.h"

namespace typodont::calibration {

EyesResult solve_eyes(std::span<const EyeAlignment> alignments, const RigGeometry& rig) {
  EyesResult result;
  result.eyes = rig.eyes;
  const auto count = [&](bool right) {
    return std::count_if(alignments.begin(), alignments.end(), [&](const EyeAlignment& a) { return a.right == right; });
  };
  if (count(false) < 2 || count(true) < 2) {
    result.not_determined = "at least two alignments of each eye, at different depths and places, are needed";
    return result;
  }
  const dvec3 left0 = rig.eyes.left_eye(), right0 = rig.eyes.right_eye();
  const auto eye_of = [&](const Eigen::VectorXd& x, bool right) {
    return right ? right0 + dvec3(x[3], x[4], x[5]) : left0 + dvec3(x[0], x[1], x[2]);
  };
  Eigen::VectorXd x = Eigen::VectorXd::Zero(6), scale = Eigen::VectorXd::Constant(6, 0.06);
  const LeastSquares solved =
      solve_least_squares(x, scale, alignments.size(), 2, [&](const Eigen::VectorXd& at, std::size_t i, double* r) {
        const EyeAlignment& a = alignments[i];
        const dvec3 eye = eye_of(at, a.right), dot = rig.appears(a.dot.u, a.dot.v, eye);
        const dvec3 sight = glm::normalize(dot - eye);
        // Residual along two axes perpendicular to the line of sight.
        const dvec3 across = glm::normalize(glm::cross(sight, dvec3(0.36, 0.48, 0.8)));
        const dvec3 other = glm::cross(sight, across), e = a.p_W - eye;
        r[0] = glm::dot(across, e), r[1] = glm::dot(other, e);
      });
  const dvec3 left = eye_of(solved.x, false), right = eye_of(solved.x, true);
  result.eyes.center = 0.5 * (left + right);
  result.eyes.ipd = glm::length(right - left);
  result.eyes.right = (right - left) / result.eyes.ipd;
  Eigen::Matrix<double, 3, 6> to_center;
  to_center << 0.5 * Eigen::Matrix3d::Identity(), 0.5 * Eigen::Matrix3d::Identity();
  const Eigen::Matrix<double, 6, 6> covariance = solved.covariance;
  const Eigen::Matrix3d center = to_center * covariance * to_center.transpose();
  Eigen::Matrix<double, 6, 1> to_ipd;
  const dvec3& d = result.eyes.right;
  to_ipd << -d.x, -d.y, -d.z, d.x, d.y, d.z;
  result.center_sigma = vec(center.diagonal().cwiseSqrt());
  result.ipd_sigma = std::sqrt(to_ipd.dot(covariance * to_ipd));
  store_residuals(result, solved);
  if (solved.open_axes.cols() > 0) {
    // Unknowns 0 to 2: left eye; 3 to 5: right eye. Each column of open_axes is a direction that is not determined. The
    // largest component of the first column names one undetermined eye (the other may be undetermined, too).
    Eigen::Index worst = 0;
    solved.open_axes.col(0).cwiseAbs().maxCoeff(&worst);
    result.not_determined = std::string("the distance of the ") + (worst < 3 ? "left" : "right") +
                            " eye along its line of sight: align at more depths, and towards more sides";
  }
  return result;
}

UserOffset user_offset_of(std::span<const SeenTouch> touches) {
  std::vector<double> axis(touches.size());
  dvec3 middle;
  for (int i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < touches.size(); ++k) axis[k] = touches[k].touched_W[i] - touches[k].shown_W[i];
    middle[i] = median(axis);
  }
  std::vector<double> far(touches.size());
  for (std::size_t k = 0; k < touches.size(); ++k)
    far[k] = glm::length(touches[k].touched_W - touches[k].shown_W - middle);
  // Limit of 5.5 standard deviations from the median offset.
  const double limit = std::max(1e-9, 5.5 * sigma_of_lengths(far, 3));
  UserOffset offset;
  offset.touches = static_cast<int>(touches.size());
  dvec3 squares(0);
  for (std::size_t k = 0; k < touches.size(); ++k) {
    if (far[k] > limit) {
      ++offset.rejected;
      continue;
    }
    const dvec3 e = touches[k].touched_W - touches[k].shown_W;
    offset.W += e, squares += e * e;
  }
  const double n = offset.touches - offset.rejected;
  offset.W /= n;
  if (n > 1) offset.sigma = glm::sqrt(glm::max(squares / n - offset.W * offset.W, dvec3(0)) / (n - 1));
  return offset;
}

}  // namespace typodont::calibration
