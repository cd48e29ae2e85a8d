#include "calibration/screen_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/registration_solver.h"
#include "calibration/solver/least_squares.h"
#include "engine/base/error.h"

namespace typodont::calibration {

namespace {

dquat rotation_vector(const dvec3& v) {
  const double angle = glm::length(v);
  if (angle < 1e-12) return glm::normalize(dquat(1, 0.5 * v.x, 0.5 * v.y, 0.5 * v.z));
  const dvec3 axis = v * (std::sin(0.5 * angle) / angle);
  return {std::cos(0.5 * angle), axis.x, axis.y, axis.z};
}

}  // namespace

PanelResult solve_panel(std::span<const MarkTouch> touches, double tip_radius) {
  PanelResult result;
  if (touches.size() < 3) {
    result.not_determined =
        fmt::format("{} touches: at least three marks that do not lie on one line are needed", touches.size());
    return result;
  }
  // Least squares for p = c + (u - ½) a + (v - ½) b; |a| and |b| are width and height.
  Eigen::MatrixXd A(static_cast<Eigen::Index>(touches.size()), 3), P(static_cast<Eigen::Index>(touches.size()), 3);
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    A.row(row) << 1, touches[i].mark.u - 0.5, touches[i].mark.v - 0.5;
    P.row(row) << touches[i].p_W.x, touches[i].p_W.y, touches[i].p_W.z;
  }
  const Decomposition plane = decompose(A);
  if (plane.rank() < 3) {
    result.not_determined =
        "the marks lie on one line: the panel may turn about it, and its size across it is not determined";
    return result;
  }
  const Eigen::MatrixXd affine = least_norm_solution(plane, P);
  const auto row = [&](Eigen::Index i) { return dvec3(affine(i, 0), affine(i, 1), affine(i, 2)); };
  const double width = glm::length(row(1)), height = glm::length(row(2));
  const std::vector<dvec3> flat{{-width / 2, 0, 0}, {width / 2, 0, 0}, {0, height / 2, 0}, {0, -height / 2, 0}};
  const std::vector<dvec3> seen{row(0) - 0.5 * row(1), row(0) + 0.5 * row(1), row(0) + 0.5 * row(2),
                                row(0) - 0.5 * row(2)};
  // Pose X_WP of the panel: origin in its middle, z towards the viewer.
  const Pose X0 = fit_rigid(flat, seen);

  const auto unpack = [&](const Eigen::VectorXd& x) {
    const dquat R = rotation_vector(dvec3(x[3], x[4], x[5])) * X0.R;
    const dvec3 centre = X0.p + dvec3(x[0], x[1], x[2]);
    const dvec3 right = R * dvec3(x[6], 0, 0), up = R * dvec3(0, x[7], 0);
    const dvec3 corner = centre - 0.5 * right - 0.5 * up;
    return std::pair{Panel{corner, corner + right, corner + up}, R * dvec3(0, 0, 1)};
  };
  Eigen::VectorXd x(8), scale(8);
  x << 0, 0, 0, 0, 0, 0, width, height;
  scale << 0.01, 0.01, 0.01, 0.05, 0.05, 0.05, 0.01, 0.01;
  const LeastSquares solved =
      solve_least_squares(x, scale, touches.size(), 3, [&](const Eigen::VectorXd& at, std::size_t i, double* r) {
        const auto [panel, normal] = unpack(at);
        const dvec3 e = panel.at(touches[i].mark.u, touches[i].mark.v) + tip_radius * normal - touches[i].p_W;
        r[0] = e.x, r[1] = e.y, r[2] = e.z;
      });
  result.panel = unpack(solved.x).first;
  result.width = solved.x[6], result.height = solved.x[7];
  const auto sd = [&](Eigen::Index i) { return std::sqrt(std::max(0.0, solved.covariance(i, i))); };
  result.width_sigma = sd(6), result.height_sigma = sd(7);
  result.centre_sigma = {sd(0), sd(1), sd(2)};
  result.tilt_sigma = std::max({sd(3), sd(4), sd(5)});
  store_residuals(result, solved);
  if (solved.open_axes.cols() > 0) {
    result.not_determined = "the touches are too close together for their noise: spread them to the panel's corners";
  }
  return result;
}

MirrorResult solve_mirror(std::span<const dvec3> touches, const dvec3& seen_from, double tip_radius) {
  MirrorResult result;
  if (touches.size() < 3) {
    result.not_determined =
        fmt::format("{} touches: at least three that do not lie on one line are needed", touches.size());
    return result;
  }
  dvec3 centre(0);
  for (const dvec3& p : touches) centre += p / static_cast<double>(touches.size());
  const auto axes = eigen_of(scatter_about(centre, touches));
  dvec3 normal = vec(axes.eigenvectors().col(0));
  const dvec3 e1 = vec(axes.eigenvectors().col(1)), e2 = vec(axes.eigenvectors().col(2));
  if (glm::dot(normal, seen_from - centre) < 0) normal = -normal;
  const auto unpack = [&](const Eigen::VectorXd& x) {
    const dvec3 tilted = glm::normalize(normal + x[0] * e1 + x[1] * e2);
    return MirrorPlane{tilted, glm::dot(tilted, centre) + x[2]};
  };
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3), scale(3);
  scale << 0.02, 0.02, 0.01;
  const LeastSquares solved =
      solve_least_squares(x, scale, touches.size(), 1, [&](const Eigen::VectorXd& at, std::size_t i, double* r) {
        const MirrorPlane plane = unpack(at);
        r[0] = glm::dot(plane.normal, touches[i]) - plane.offset - tip_radius;
      });
  result.mirror = unpack(solved.x);
  const auto sd = [&](Eigen::Index i) { return std::sqrt(std::max(0.0, solved.covariance(i, i))); };
  result.tilt_sigma = std::max(sd(0), sd(1)), result.offset_sigma = sd(2);
  store_residuals(result, solved);
  if (solved.open_axes.cols() > 0 || axes.eigenvalues()[1] < 25 * axes.eigenvalues()[0]) {
    result.not_determined =
        "the touches lie on one line, or too close together for their noise: the mirror may tilt about it";
  }
  return result;
}

}  // namespace typodont::calibration
