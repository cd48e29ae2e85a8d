#include "engine/surface/contour/plane_fit.h"

#include <algorithm>

namespace typodont::surface {
namespace {

// Eigenvectors of a symmetric 3×3 matrix by cyclic Jacobi rotations; columns of `v`.
void eigen(double a[3][3], double v[3][3]) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) v[i][j] = i == j;
  }
  for (int sweep = 0; sweep < 12; ++sweep) {
    const double off = a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2];
    if (off < 1e-24) return;
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (std::abs(a[p][q]) < 1e-300) continue;
        const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t = (theta < 0 ? -1.0 : 1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (int k = 0; k < 3; ++k) {
          const double akp = a[k][p], akq = a[k][q];
          a[k][p] = c * akp - s * akq;
          a[k][q] = s * akp + c * akq;
        }
        for (int k = 0; k < 3; ++k) {
          const double apk = a[p][k], aqk = a[q][k];
          a[p][k] = c * apk - s * aqk;
          a[q][k] = s * apk + c * aqk;
          const double vkp = v[k][p], vkq = v[k][q];
          v[k][p] = c * vkp - s * vkq;
          v[k][q] = s * vkp + c * vkq;
        }
      }
    }
  }
}

}  // namespace

PlaneFit fit_planes(const CrossingSums& sums, double cutoff) {
  const double m[3] = {static_cast<double>(sums.x.x) / sums.count, static_cast<double>(sums.x.y) / sums.count,
                       static_cast<double>(sums.x.z) / sums.count};
  const double n00 = sums.nn[0], n01 = sums.nn[1], n02 = sums.nn[2], n11 = sums.nn[3], n12 = sums.nn[4],
               n22 = sums.nn[5];
  const double nm[3] = {n00 * m[0] + n01 * m[1] + n02 * m[2], n01 * m[0] + n11 * m[1] + n12 * m[2],
                        n02 * m[0] + n12 * m[1] + n22 * m[2]};
  // Relative to the mean: A y = b.
  const double b[3] = {sums.nd.x - nm[0], sums.nd.y - nm[1], sums.nd.z - nm[2]};
  double a[3][3] = {{n00, n01, n02}, {n01, n11, n12}, {n02, n12, n22}};
  double v[3][3];
  eigen(a, v);
  const double greatest = std::max({a[0][0], a[1][1], a[2][2]});

  PlaneFit fit;
  double y[3] = {0, 0, 0};
  double explained = 0;
  for (int i = 0; i < 3; ++i) {
    if (a[i][i] <= cutoff * greatest) continue;
    ++fit.rank;
    const double along = v[0][i] * b[0] + v[1][i] * b[1] + v[2][i] * b[2];
    const double step = along / a[i][i];
    for (int k = 0; k < 3; ++k) y[k] += step * v[k][i];
    explained += along * step;
  }
  const double at_mean = static_cast<double>(sums.dd) -
                         2 * (m[0] * sums.nd.x + m[1] * sums.nd.y + m[2] * sums.nd.z) +
                         (m[0] * nm[0] + m[1] * nm[1] + m[2] * nm[2]);
  fit.point = {static_cast<float>(m[0] + y[0]), static_cast<float>(m[1] + y[1]), static_cast<float>(m[2] + y[2])};
  fit.residual = static_cast<float>(std::sqrt(std::max(0.0, (at_mean - explained) / sums.count)));
  return fit;
}

}  // namespace typodont::surface
