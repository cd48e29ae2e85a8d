#include "engine/surface/contour/plane_fit.h"

#include <algorithm>
#include <cmath>

namespace typodont::surface {
namespace {

// Cyclic Jacobi method. The columns of `v` become the eigenvectors of `a`, its diagonal the eigenvalues.
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

PlaneFit fit_planes(const PlaneSums& sums, double cutoff, int most) {
  const glm::dvec3 m = sums.point / sums.count;
  const double n00 = sums.nn[0], n01 = sums.nn[1], n02 = sums.nn[2], n11 = sums.nn[3], n12 = sums.nn[4],
               n22 = sums.nn[5];
  const glm::dvec3 nm(n00 * m.x + n01 * m.y + n02 * m.z, n01 * m.x + n11 * m.y + n12 * m.z,
                      n02 * m.x + n12 * m.y + n22 * m.z);
  // Solves A y = b (A: Σ n nᵀ) for the point y, relative to the mean of the crossings.
  const glm::dvec3 b = sums.nd - nm;
  double a[3][3] = {{n00, n01, n02}, {n01, n11, n12}, {n02, n12, n22}};
  double v[3][3];
  eigen(a, v);
  int order[3] = {0, 1, 2};
  std::sort(order, order + 3, [&a](int i, int j) { return a[i][i] > a[j][j]; });
  const double greatest = a[order[0]][order[0]];

  PlaneFit fit;
  double y[3] = {0, 0, 0};
  double explained = 0;
  for (const int i : order) {
    if (a[i][i] <= cutoff * greatest || fit.rank == most) break;
    ++fit.rank;
    const double along = v[0][i] * b.x + v[1][i] * b.y + v[2][i] * b.z;
    const double step = along / a[i][i];
    for (int k = 0; k < 3; ++k) y[k] += step * v[k][i];
    explained += along * step;
  }
  const double at_mean = sums.dd - 2 * glm::dot(m, sums.nd) + glm::dot(m, nm);
  fit.point = glm::vec3(m + glm::dvec3(y[0], y[1], y[2]));
  fit.residual = static_cast<float>(std::sqrt(std::max(0.0, (at_mean - explained) / sums.count)));
  return fit;
}

}  // namespace typodont::surface
