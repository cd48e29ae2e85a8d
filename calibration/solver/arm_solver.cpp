#include "calibration/arm_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "calibration/registration_solver.h"
#include "calibration/solver/eigen_math.h"
#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont::calibration {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Group {
  bool plate = false;
  std::vector<std::size_t> captures;
  // Index of the first unknown of this socket (3 unknowns: position) or plate (6 unknowns: pose).
  std::size_t first_parameter = 0;
};

}  // namespace

std::array<double, kArmParameters> arm_parameter_scales() {
  std::array<double, kArmParameters> scales{};
  for (std::size_t i = 0; i < kArmParameters; ++i) {
    const double unit = arm_parameter_unit(arm_parameter_names()[i]).si;
    scales[i] = unit == 1 ? 0.005 : unit;
  }
  return scales;
}

std::array<dvec3, kArmParameters> tip_derivatives(const ArmGeometry& g, const ArmReading& reading) {
  const ArmJoints joints = arm_joints(g, reading);
  const auto& q = joints.q;
  const Pose X_HS = stylus_pose(g, reading);
  const dvec3 stylus = X_HS.rotate(g.tip_S), foot_to_tip = X_HS.p + g.origin + stylus;
  const dvec3 out(std::cos(q[0]), std::sin(q[0]), 0), z(0, 0, 1), tilt(-out.y, out.x, 0);
  const dvec3 by_a = glm::cross(z, foot_to_tip);
  // By the true angles B and C.
  const dvec3 by_b = g.upper * (std::cos(q[1]) * out - std::sin(q[1]) * z);
  const dvec3 by_c = g.fore * (std::cos(q[2]) * out + std::sin(q[2]) * z) - glm::cross(tilt, stylus);
  // Sag: B = b + sag_B (Lb sin b + Lc sin c), C = c + sag_C Lc sin c; b, c: angles without sag.
  const auto [b, c] = joints.before;
  const dvec3 fore_bends = g.sag[0] * by_b + g.sag[1] * by_c;
  const dvec3 by_angle_b = by_b * (1 + g.sag[0] * g.upper * std::cos(b));
  const dvec3 by_angle_c = by_c + g.fore * std::cos(c) * fore_bends;
  const glm::dmat3 R = glm::mat3_cast(X_HS.R);
  // Axes of the joints D, E, F: x after C, y after D, x after E.
  const dvec3 axis_f = R[0];
  const glm::dmat3 before_f = R * glm::mat3_cast(glm::angleAxis(-q[5], dvec3(1, 0, 0)));
  const glm::dmat3 before_e = before_f * glm::mat3_cast(glm::angleAxis(-q[4], dvec3(0, 1, 0)));
  return {std::sin(q[1]) * out + std::cos(q[1]) * z + g.sag[0] * std::sin(b) * by_b,
          std::sin(q[2]) * out - std::cos(q[2]) * z + std::sin(c) * fore_bends,
          by_a,
          by_angle_b,
          by_angle_c,
          by_a * reading.angle[0],
          by_angle_b * reading.angle[1],
          by_angle_c * reading.angle[2],
          z,
          dvec3(-1, 0, 0),
          dvec3(0, -1, 0),
          dvec3(0, 0, -1),
          R[0],
          R[1],
          R[2],
          glm::cross(before_e[0], stylus),
          glm::cross(before_f[1], stylus),
          glm::cross(axis_f, stylus),
          by_b * joints.lever[0],
          by_c * joints.lever[1]};
}

ArmResult solve_arm(std::span<const ArmCapture> captures, const ArmGeometry& nominal) {
  if (captures.empty()) throw Error("arm: found no capture, expected the tip held in a socket or on a plate");

  // The positions of sockets and plates are unknown, too.
  std::map<int, Group> groups;
  for (std::size_t i = 0; i < captures.size(); ++i) {
    Group& group = groups[captures[i].group];
    if (!group.captures.empty() && group.plate != captures[i].known.has_value()) {
      throw Error(fmt::format("arm: capture {}: found group {} with and without known points, expected one kind", i,
                              captures[i].group));
    }
    group.plate = captures[i].known.has_value();
    group.captures.push_back(i);
  }
  std::size_t parameters = kArmParameters;
  for (auto& [id, group] : groups) {
    group.first_parameter = parameters;
    parameters += group.plate ? 6 : 3;
  }

  const auto scales = arm_parameter_scales();
  const std::array<double, kArmParameters> start = to_vector(nominal);
  std::array<double, kArmParameters> values = start;
  std::map<int, Pose> place;  // pose of each group's socket or plate in frame H
  std::vector<bool> used(captures.size(), true);

  const auto locate = [&](const std::array<double, kArmParameters>& at) {
    const ArmGeometry geometry = to_geometry(at);
    for (auto& [id, group] : groups) {
      std::vector<dvec3> tips, known;
      for (const std::size_t i : group.captures) {
        if (!used[i]) continue;
        tips.push_back(tip_position(geometry, captures[i].reading));
        known.push_back(captures[i].known.value_or(dvec3(0)));
      }
      if (tips.empty()) continue;
      if (group.plate) {
        place[id] = fit_rigid(known, tips);
      } else {
        dvec3 mean(0);
        for (const dvec3& p : tips) mean += p / static_cast<double>(tips.size());
        place[id] = {mean, dquat(1, 0, 0, 0)};
      }
    }
  };
  const auto residual = [&](const ArmGeometry& geometry, std::size_t i) {
    return tip_position(geometry, captures[i].reading) -
           place[captures[i].group] * captures[i].known.value_or(dvec3(0));
  };
  const auto rms = [&](const ArmGeometry& geometry) {
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < captures.size(); ++i) {
      if (!used[i]) continue;
      const dvec3 r = residual(geometry, i);
      sum += glm::dot(r, r), ++count;
    }
    return std::sqrt(sum / std::max(1, count));
  };

  ArmResult result;
  locate(values);
  result.before_rms = rms(nominal);

  // Gauss–Newton by variable projection: only the arm's parameters are iterated. For each set of parameters, the best
  // places of the calibration sockets and plates are computed; the Jacobian J is projected onto the complement of the
  // derivatives N by these places. A prior keeps undetermined parameters near their nominal values.
  MatrixXd open_axes;
  // Covariance of the parameters after division by their scales.
  MatrixXd covariance = MatrixXd::Zero(kArmParameters, kArmParameters);
  double sigma = 2e-4;  // m, standard deviation of a capture; first value, estimated later
  for (int round = 0; round < 60; ++round) {
    const ArmGeometry geometry = to_geometry(values);
    std::size_t rows = 0;
    for (std::size_t i = 0; i < captures.size(); ++i) rows += used[i] ? 3 : 0;
    MatrixXd J = MatrixXd::Zero(static_cast<Eigen::Index>(rows), kArmParameters);
    MatrixXd N =
        MatrixXd::Zero(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(parameters - kArmParameters));
    VectorXd r(static_cast<Eigen::Index>(rows));
    Eigen::Index row = 0;
    for (std::size_t i = 0; i < captures.size(); ++i) {
      if (!used[i]) continue;
      const dvec3 e = residual(geometry, i);
      for (int axis = 0; axis < 3; ++axis) r[row + axis] = e[axis];
      const auto slopes = tip_derivatives(geometry, captures[i].reading);
      for (std::size_t p = 0; p < kArmParameters; ++p) {
        for (int axis = 0; axis < 3; ++axis) J(row + axis, static_cast<Eigen::Index>(p)) = slopes[p][axis] * scales[p];
      }
      const Group& group = groups[captures[i].group];
      const auto first = static_cast<Eigen::Index>(group.first_parameter - kArmParameters);
      N.block(row, first, 3, 3) = -Eigen::Matrix3d::Identity();
      if (group.plate) {
        // Rotations are in units of 0.1 rad, so that all columns have similar size.
        N.block(row, first + 3, 3, 3) = 10 * cross_matrix(place[captures[i].group].rotate(*captures[i].known));
      }
      row += 3;
    }
    const Decomposition nuisance = decompose(N);
    const MatrixXd projected = J - N.lazyProduct(least_norm_solution(nuisance, J));
    const VectorXd left = r - N * VectorXd(least_norm_solution(nuisance, r));
    const auto eigen = eigen_of(MatrixXd(projected.transpose().lazyProduct(projected)));
    // A combination of parameters is determined if its standard deviation is below a third of its plausible error.
    Eigen::Index open = 0;
    while (open < eigen.eigenvalues().size() && sigma > 0.33 * std::sqrt(std::max(0.0, eigen.eigenvalues()[open]))) {
      ++open;
    }
    open_axes = eigen.eigenvectors().leftCols(open);
    const double weight = 1 / (sigma * sigma);
    const VectorXd information = weight * eigen.eigenvalues().cwiseMax(0) + VectorXd::Ones(kArmParameters);
    covariance =
        (eigen.eigenvectors() * information.cwiseInverse().asDiagonal()).lazyProduct(eigen.eigenvectors().transpose());
    VectorXd off(kArmParameters);
    for (std::size_t p = 0; p < kArmParameters; ++p)
      off[static_cast<Eigen::Index>(p)] = (values[p] - start[p]) / scales[p];
    const VectorXd step = -covariance * (weight * (projected.transpose() * left) + off);
    for (std::size_t p = 0; p < kArmParameters; ++p) values[p] += scales[p] * step[static_cast<Eigen::Index>(p)];
    locate(values);

    result.degrees_of_freedom = static_cast<int>(rows) -
                                static_cast<int>(kArmParameters - static_cast<std::size_t>(open)) -
                                static_cast<int>(nuisance.rank());
    const double total = rms(to_geometry(values));
    const double previous = sigma;
    // Limits the noise from below: with exact data and zero noise, rounding errors would seem to determine parameters.
    if (result.degrees_of_freedom > 0) {
      sigma = std::max(1e-9, total * std::sqrt(static_cast<double>(rows) / 3 / result.degrees_of_freedom));
    }
    if (round > 3 && step.norm() < 1e-7 && std::abs(sigma - previous) <= 1e-4 * sigma + 1e-13) {
      // After convergence, excludes captures that are outliers, and continues.
      bool changed = false;
      std::vector<double> sizes;
      for (std::size_t i = 0; i < captures.size(); ++i) sizes.push_back(glm::length(residual(to_geometry(values), i)));
      const double limit = std::max(1e-9, 5 * sigma_of_lengths(sizes, 3));
      for (std::size_t i = 0; i < captures.size(); ++i) {
        const bool keep = sizes[i] <= limit;
        changed = changed || keep != used[i];
        used[i] = keep;
      }
      if (!changed) break;
      locate(values);
    }
  }

  result.geometry = to_geometry(values);
  result.sigma = sigma;
  result.after_rms = rms(result.geometry);
  for (std::size_t i = 0; i < captures.size(); ++i) {
    result.residuals.push_back(glm::length(residual(result.geometry, i)));
    if (!used[i]) result.rejected.push_back(i);
  }
  for (std::size_t p = 0; p < kArmParameters; ++p) {
    const auto index = static_cast<Eigen::Index>(p);
    result.parameters.push_back({arm_parameter_names()[p], start[p], values[p],
                                 scales[p] * std::sqrt(covariance(index, index)), 1 - covariance(index, index)});
  }
  // A hand holds the tip still to about 1 mm. Larger noise means another type of arm, another plate, or slipped tips.
  if (result.sigma > 2e-3) {
    result.misfit = fmt::format(
        "{:.1f} mm rms are left: these captures are not of a serial arm with this plate, or most of them slipped",
        result.after_rms * 1e3);
  }
  // The tip rarely slips, so most captures of each group must fit.
  for (const auto& [id, group] : groups) {
    const auto kept =
        std::count_if(group.captures.begin(), group.captures.end(), [&](std::size_t i) { return used[i]; });
    if (result.misfit.empty() && 2 * static_cast<std::size_t>(kept) < group.captures.size())
      result.misfit =
          fmt::format("only {} of the {} captures of {} {} fit the others: {}", kept, group.captures.size(),
                      group.plate ? "plate" : "socket", id, group.plate ? "has it another pitch?" : "has it moved?");
  }
  // Reduced echelon form, so that each undetermined direction contains few parameters.
  if (open_axes.cols() > 0) {
    MatrixXd basis = open_axes.transpose();
    std::vector<bool> pivot(kArmParameters, false);
    for (Eigen::Index row = 0; row < basis.rows(); ++row) {
      Eigen::Index best_row = row, best_column = 0;
      basis.bottomRows(basis.rows() - row).cwiseAbs().maxCoeff(&best_row, &best_column);
      best_row += row;
      basis.row(row).swap(basis.row(best_row));
      basis.row(row) /= basis(row, best_column);
      for (Eigen::Index other = 0; other < basis.rows(); ++other) {
        if (other != row) basis.row(other) -= basis(other, best_column) * basis.row(row);
      }
    }
    for (Eigen::Index row = 0; row < basis.rows(); ++row) {
      std::vector<std::string> names;
      for (Eigen::Index p = 0; p < basis.cols(); ++p) {
        if (std::abs(basis(row, p)) > 0.1) names.emplace_back(arm_parameter_names()[static_cast<std::size_t>(p)]);
      }
      result.not_observable.push_back(fmt::format("{}", fmt::join(names, " with ")));
    }
  }
  return result;
}

}  // namespace typodont::calibration
