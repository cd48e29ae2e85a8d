#include "calibration/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/solver/eigen_math.h"
#include "calibration/statistics.h"
#include "engine/base/error.h"

namespace typodont::calibration {

namespace {

// Polynomial basis 1, x, y, z, x², y², z², xy, xz, yz, with coordinates scaled to ±1.
Eigen::VectorXd basis(const dvec3& p, const Box& box, int order) {
  const dvec3 q = (p - 0.5 * (box.low + box.high)) / glm::max(0.5 * (box.high - box.low), dvec3(1e-9));
  Eigen::VectorXd b(order == 0 ? 1 : order == 1 ? 4 : 10);
  b[0] = 1;
  if (order >= 1) b.segment<3>(1) << q.x, q.y, q.z;
  if (order >= 2) b.segment<6>(4) << q.x * q.x, q.y * q.y, q.z * q.z, q.x * q.y, q.x * q.z, q.y * q.z;
  return b;
}

}  // namespace

VerifyResult verify(std::span<const dvec3> p_H, std::span<const dvec3> p_D, const Pose& X_DH,
                    const Tolerance& tolerance, const Box& workspace_D) {
  if (p_H.empty() || p_H.size() != p_D.size()) throw Error("verify: found no pairs of points, expected at least one");
  VerifyResult result;
  result.tolerance = tolerance;
  result.points = static_cast<int>(p_H.size());
  result.workspace_D = workspace_D;
  Box& box = result.workspace_D;
  if (box.low == box.high) {
    box.low = box.high = p_D[0];
    for (const dvec3& p : p_D) box.low = glm::min(box.low, p), box.high = glm::max(box.high, p);
  }
  std::vector<dvec3> error(p_H.size());
  for (std::size_t i = 0; i < p_H.size(); ++i) {
    error[i] = X_DH * p_H[i] - p_D[i];
    const double size = glm::length(error[i]);
    result.residuals.push_back(size);
    result.raw_mean += size / static_cast<double>(p_H.size());
    result.raw_rms += size * size / static_cast<double>(p_H.size());
    result.raw_worst = std::max(result.raw_worst, size);
  }
  result.raw_rms = std::sqrt(result.raw_rms);

  // A smooth field fitted to the errors is the systematic error; its residuals are the noise.
  std::vector<bool> used(p_H.size(), true);
  Eigen::MatrixXd field, inverse;
  for (int round = 0; round < 6; ++round) {
    const auto n = static_cast<std::size_t>(std::count(used.begin(), used.end(), true));
    result.order = n >= 40 ? 2 : n >= 12 ? 1 : 0;
    const Eigen::Index terms = basis(p_D[0], box, result.order).size();
    Eigen::MatrixXd AA = Eigen::MatrixXd::Zero(terms, terms), AE = Eigen::MatrixXd::Zero(terms, 3);
    for (std::size_t i = 0; i < p_D.size(); ++i) {
      if (!used[i]) continue;
      const Eigen::VectorXd b = basis(p_D[i], box, result.order);
      AA += b * b.transpose();
      AE += b * Eigen::RowVector3d(error[i].x, error[i].y, error[i].z);
    }
    // Regularization (ridge), far smaller than the weight of one touched point, for points that all lie in a plane.
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(terms, terms);
    inverse = definite_solution(AA + 1e-6 * unit, unit);
    field = inverse.lazyProduct(AE);
    double squares = 0;
    std::vector<double> off;
    for (std::size_t i = 0; i < p_D.size(); ++i) {
      const Eigen::RowVector3d fitted = basis(p_D[i], box, result.order).transpose() * field;
      off.push_back(glm::length(error[i] - dvec3(fitted[0], fitted[1], fitted[2])));
      if (used[i]) squares += off.back() * off.back();
    }
    const double dof = 3.0 * (static_cast<double>(n) - static_cast<double>(terms));
    result.noise = dof > 0 ? std::sqrt(squares / dof) : 0.0;
    bool changed = false;
    if (dof >= 9) {
      for (std::size_t i = 0; i < off.size(); ++i) {
        const bool keep = off[i] <= 5.5 * result.noise || off[i] < 1e-9;
        changed = changed || keep != used[i];
        used[i] = keep;
      }
    }
    if (!changed) break;
  }
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) result.outliers.push_back(i);
  }

  constexpr int kSide = 9;
  double squares = 0, noise2 = 0;
  for (int k = 0; k < kSide * kSide * kSide; ++k) {
    const dvec3 s(k % kSide, k / kSide % kSide, k / (kSide * kSide));
    MapPoint point;
    point.p_D = box.low + (box.high - box.low) * s / static_cast<double>(kSide - 1);
    const Eigen::VectorXd b = basis(point.p_D, box, result.order);
    const Eigen::RowVector3d e = b.transpose() * field;
    point.error_D = {e[0], e[1], e[2]};
    point.sigma = result.noise * std::sqrt(3 * std::max(0.0, b.dot(inverse * b)));
    squares += glm::dot(point.error_D, point.error_D), noise2 += point.sigma * point.sigma;
    result.worst = std::max(
        result.worst, std::sqrt(std::max(0.0, glm::dot(point.error_D, point.error_D) - point.sigma * point.sigma)));
    result.map.push_back(point);
  }
  const auto n = static_cast<double>(result.map.size());
  result.rms = std::sqrt(std::max(0.0, (squares - noise2) / n));
  result.uncertainty = std::sqrt(noise2 / n);

  const bool enough = result.uncertainty <= tolerance.rms && result.points >= 4;
  result.pass = enough && result.rms <= tolerance.rms && result.worst <= tolerance.worst;
  result.verdict = !enough
                       ? fmt::format("not enough points: the error is known to {:.3f} mm only, {:.3f} mm is asked for",
                                     result.uncertainty * 1e3, tolerance.rms * 1e3)
                       : fmt::format(
                             "{}: {:.3f} mm rms (known to ± {:.3f}), {:.3f} mm worst over the workspace; tolerance "
                             "{:.3f} and {:.3f} mm",
                             result.pass ? "pass" : "fail", result.rms * 1e3, result.uncertainty * 1e3,
                             result.worst * 1e3, tolerance.rms * 1e3, tolerance.worst * 1e3);
  return result;
}

DriftResult check_drift(std::span<const dvec3> then_H, std::span<const dvec3> now_H, double touch_sigma,
                        const dvec3& center_H, double tolerance) {
  if (then_H.size() < 3 || then_H.size() != now_H.size()) {
    throw Error(
        fmt::format("drift: found {} and {} points, expected the same three or more", then_H.size(), now_H.size()));
  }
  DriftResult result;
  const Pose X = fit_rigid(then_H, now_H);
  result.shift = glm::length(X * center_H - center_H);
  result.turn = 2 * std::asin(std::min(1.0, glm::length(dvec3(X.R.x, X.R.y, X.R.z))));
  double squares = 0;
  for (std::size_t i = 0; i < then_H.size(); ++i) {
    const double moved = glm::length(now_H[i] - then_H[i]);
    result.worst = std::max(result.worst, moved);
    squares += moved * moved;
  }
  // A displacement is the difference of two touched points. Each has the variance σ² on three axes, so the sum is 6 σ².
  result.sigma = std::sqrt(6.0) * touch_sigma;
  const double chance =
      2 * touch_sigma * touch_sigma * chi_squared_quantile(0.99, 3.0 * static_cast<double>(then_H.size()));
  result.drifted = squares > chance && result.worst > tolerance;
  result.verdict =
      result.drifted
          ? fmt::format("drifted: {:.3f} mm at the workspace's middle, {:.3f} mm at the worst mark; calibrate again",
                        result.shift * 1e3, result.worst * 1e3)
          : fmt::format("no drift: {:.3f} mm at the worst mark, {:.3f} mm expected from touching alone",
                        result.worst * 1e3, result.sigma * 1e3);
  return result;
}

}  // namespace typodont::calibration
