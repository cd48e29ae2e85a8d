// Closed-form rigid fit of point pairs, the only part of the solvers that must be fast.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "calibration/registration_solver.h"

namespace typodont::calibration {

Pose fit_rigid(std::span<const dvec3> p_H, std::span<const dvec3> p_D) noexcept {
  const std::size_t n = std::min(p_H.size(), p_D.size());
  if (n == 0) return {};

  // Scales the points to size 1, so that points of size 1e-6 and 1e6 are treated alike.
  dvec3 c_H(0), c_D(0);
  for (std::size_t i = 0; i < n; ++i) c_H += p_H[i], c_D += p_D[i];
  c_H /= static_cast<double>(n), c_D /= static_cast<double>(n);
  double m[3][3] = {};
  double spread = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const dvec3 h = p_H[i] - c_H, d = p_D[i] - c_D;
    spread += glm::dot(h, h) + glm::dot(d, d);
    m[0][0] += d.x * h.x, m[0][1] += d.x * h.y, m[0][2] += d.x * h.z;
    m[1][0] += d.y * h.x, m[1][1] += d.y * h.y, m[1][2] += d.y * h.z;
    m[2][0] += d.z * h.x, m[2][1] += d.z * h.y, m[2][2] += d.z * h.z;
  }
  if (!(spread > 0)) return {c_D - c_H, dquat(1, 0, 0, 0)};
  for (auto& row : m) {
    for (double& x : row) x *= 2 / spread;  // eigenvalues of K at most 1
  }

  // Horn 1987: the rotation is the eigenvector of K for its largest eigenvalue.
  const double xx = m[0][0], xy = m[0][1], xz = m[0][2], yx = m[1][0], yy = m[1][1], yz = m[1][2], zx = m[2][0],
               zy = m[2][1], zz = m[2][2];
  double K[4][4] = {{xx + yy + zz, zy - yz, xz - zx, yx - xy},
                    {zy - yz, xx - yy - zz, xy + yx, xz + zx},
                    {xz - zx, xy + yx, yy - xx - zz, yz + zy},
                    {yx - xy, xz + zx, yz + zy, zz - xx - yy}};
  // Largest eigenvalue by Newton's method from above on λ⁴ + c2 λ² + c1 λ + c0 (Theobald 2005).
  double c2 = 0;
  for (const auto& row : m) {
    for (const double x : row) c2 -= 2 * x * x;
  }
  const double det_m = xx * (yy * zz - yz * zy) - xy * (yx * zz - yz * zx) + xz * (yx * zy - yy * zx);
  const double c1 = -8 * det_m;
  const auto minor2 = [&](int r, int s, int a, int b) { return K[r][a] * K[s][b] - K[r][b] * K[s][a]; };
  const double c0 = minor2(0, 1, 0, 1) * minor2(2, 3, 2, 3) - minor2(0, 1, 0, 2) * minor2(2, 3, 1, 3) +
                    minor2(0, 1, 0, 3) * minor2(2, 3, 1, 2) + minor2(0, 1, 1, 2) * minor2(2, 3, 0, 3) -
                    minor2(0, 1, 1, 3) * minor2(2, 3, 0, 2) + minor2(0, 1, 2, 3) * minor2(2, 3, 0, 1);
  double lambda = 1;
  for (int i = 0; i < 30; ++i) {
    const double value = ((lambda * lambda + c2) * lambda + c1) * lambda + c0;
    const double slope = (4 * lambda * lambda + 2 * c2) * lambda + c1;
    if (!(std::abs(slope) > 1e-14)) break;
    const double step = value / slope;
    lambda -= step;
    if (std::abs(step) < 1e-13) break;
  }
  // Each row of adj(K - λ) is a multiple of the eigenvector. Uses the longest row: it has the largest diagonal element.
  for (int i = 0; i < 4; ++i) K[i][i] -= lambda;
  const auto cofactor = [&](int row, int col) {
    int r[3], c[3];
    for (int i = 0, k = 0; i < 4; ++i) {
      if (i != row) r[k++] = i;
    }
    for (int i = 0, k = 0; i < 4; ++i) {
      if (i != col) c[k++] = i;
    }
    const double det = K[r[0]][c[0]] * minor2(r[1], r[2], c[1], c[2]) - K[r[0]][c[1]] * minor2(r[1], r[2], c[0], c[2]) +
                       K[r[0]][c[2]] * minor2(r[1], r[2], c[0], c[1]);
    return (row + col) % 2 ? -det : det;
  };
  int row = 0;
  double longest = 0;
  for (int i = 0; i < 4; ++i) {
    const double diagonal = std::abs(cofactor(i, i));
    if (diagonal > longest) longest = diagonal, row = i;
  }
  dquat R(cofactor(row, 0), cofactor(row, 1), cofactor(row, 2), cofactor(row, 3));
  const double length2 = glm::dot(R, R);
  if (longest > 1e-5 && length2 > 1e-10) {
    R *= 1 / std::sqrt(length2);
  } else {
    // Two nearly equal eigenvalues: the slower solver finds the eigenvector of the largest.
    for (int i = 0; i < 4; ++i) K[i][i] += lambda;
    const Eigen::Vector4d q =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(Eigen::Map<Eigen::Matrix4d>(K[0])).eigenvectors().col(3);
    R = {q[0], q[1], q[2], q[3]};
  }

  // Two Newton steps δ refine the rotation R: they maximise tr(exp(-[δ]) B), B = m Rᵀ, by (tr B - sym B) δ = axial(B).
  for (int polish = 0; polish < 2; ++polish) {
    const glm::dmat3 r = glm::mat3_cast(R);  // r[column][row]
    double B[3][3];
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) B[i][j] = m[i][0] * r[0][j] + m[i][1] * r[1][j] + m[i][2] * r[2][j];
    }
    const double trace = B[0][0] + B[1][1] + B[2][2];
    const dvec3 w(B[2][1] - B[1][2], B[0][2] - B[2][0], B[1][0] - B[0][1]);
    const double a = trace - B[0][0], b = trace - B[1][1], c = trace - B[2][2];
    const double d = -0.5 * (B[0][1] + B[1][0]), e = -0.5 * (B[0][2] + B[2][0]), f = -0.5 * (B[1][2] + B[2][1]);
    const double det = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e);
    if (!(det > 1e-12)) break;  // the rotation is undetermined, so nothing can be refined
    const dvec3 delta((w.x * (b * c - f * f) + w.y * (e * f - d * c) + w.z * (d * f - b * e)) / det,
                      (w.x * (e * f - d * c) + w.y * (a * c - e * e) + w.z * (d * e - a * f)) / det,
                      (w.x * (d * f - b * e) + w.y * (d * e - a * f) + w.z * (a * b - d * d)) / det);
    R = glm::normalize(dquat(1, 0.5 * delta.x, 0.5 * delta.y, 0.5 * delta.z) * R);
  }
  if (R.w < 0) R = -R;
  return {c_D - R * c_H, R};
}

}  // namespace typodont::calibration
