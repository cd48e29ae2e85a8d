// Conversions between GLM and Eigen, decompositions, and robust statistics of residuals. Used only by .cpp files of
// this module.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <span>
#include <vector>

#include "engine/base/pose.h"
#include "engine/base/quantile.h"

namespace typodont::calibration {

inline Eigen::Vector3d eigen(const dvec3& v) {
  return {v.x, v.y, v.z};
}
inline Eigen::Matrix3d eigen(const dquat& q) {
  return Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
}
inline dvec3 vec(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

/// Sum of d dᵀ over the vectors d from `centre` to the points.
inline Eigen::Matrix3d scatter_about(const dvec3& centre, std::span<const dvec3> points) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const dvec3& p : points) sum += eigen(p - centre) * eigen(p - centre).transpose();
  return sum;
}

/// The matrix [v] with [v] w = v × w.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}
inline Eigen::Matrix3d cross_matrix(const dvec3& v) {
  return cross_matrix(eigen(v));
}

// Decompositions. They are functions of one file, because Eigen's templates take long to compile.
using Decomposition = Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>;
Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen_of(const Eigen::MatrixXd& symmetric);
Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen_of(const Eigen::Matrix3d& symmetric);
Decomposition decompose(const Eigen::MatrixXd& A);
/// Least-squares solution X of A X = B with the least norm.
Eigen::MatrixXd least_norm_solution(const Decomposition& A, const Eigen::MatrixXd& B);
/// Solution X of A X = B for a positive definite matrix A.
Eigen::MatrixXd definite_solution(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
/// The rotation that differs least from M (sum of squares).
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& M);

/// The value in the middle of the sorted values; 0 if there are none.
inline double median(std::vector<double> values) {
  return values.empty() ? 0 : nth(values, values.size() / 2);
}

/// Standard deviation per component of normally distributed errors with 1, 2 or 3 components, from the median of their
/// lengths.
inline double sigma_of_lengths(const std::vector<double>& lengths, int components) {
  return median(lengths) / (components == 1 ? 0.6745 : components == 2 ? 1.1774 : 1.5382);
}

}  // namespace typodont::calibration
