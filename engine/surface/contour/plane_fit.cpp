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

PlaneFit fit_planes(const CrossingSums& sums, double cutoff, int most) {
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
  int order[3] = {0, 1, 2};
  std::sort(order, order + 3, [&a](int i, int j) { return a[i][i] > a[j][j]; });
  const double greatest = a[order[0]][order[0]];

  PlaneFit fit;
  double y[3] = {0, 0, 0};
  double explained = 0;
  for (const int i : order) {
    if (a[i][i] <= cutoff * greatest || fit.rank == most) break;
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

float greatest_curvature(const CrossingSums& sums, float least) {
  const float w = 1 / sums.count, mean_curvature = sums.curvature * w;
  const glm::vec3 x = sums.x * w, n = sums.n * w;
  const float length = glm::length(n);
  if (length < 1e-6f) return 1;
  const glm::vec3 unit = n / length;
  const glm::vec3 u = glm::normalize(std::abs(unit.x) < 0.7f ? glm::vec3(0, -unit.z, unit.y)
                                                             : glm::vec3(unit.y, -unit.x, 0));
  const glm::vec3 v = glm::cross(unit, u);

  // Covariances in the tangent plane: of places X, and of normals with places C. Shape operator S = C X⁻¹.
  const std::array<float, 6>& m = sums.xx;
  auto place = [&](const glm::vec3& a, const glm::vec3& b) {
    return w * (a.x * (m[0] * b.x + m[1] * b.y + m[2] * b.z) + a.y * (m[1] * b.x + m[3] * b.y + m[4] * b.z) +
                a.z * (m[2] * b.x + m[4] * b.y + m[5] * b.z)) -
           glm::dot(a, x) * glm::dot(b, x);
  };
  auto change = [&](const glm::vec3& a, const glm::vec3& b) {  // of the normal along a with the place along b
    return w * glm::dot(a, sums.nx * b) - glm::dot(a, n) * glm::dot(b, x);
  };
  const float xuu = place(u, u) + least, xvv = place(v, v) + least, xuv = place(u, v);
  const float cuu = change(u, u) + least * mean_curvature, cvv = change(v, v) + least * mean_curvature;
  const float cuv = change(u, v), cvu = change(v, u);
  const float determinant = xuu * xvv - xuv * xuv;
  if (!(determinant > 0)) return std::abs(mean_curvature);
  const float suu = (cuu * xvv - cuv * xuv) / determinant, suv = (cuv * xuu - cuu * xuv) / determinant;
  const float svu = (cvu * xvv - cvv * xuv) / determinant, svv = (cvv * xuu - cvu * xuv) / determinant;
  const float middle = 0.5f * (suu + svv), shear = 0.5f * (suv + svu), stretch = 0.5f * (suu - svv);
  return std::abs(middle) + std::sqrt(stretch * stretch + shear * shear);
}

}  // namespace typodont::surface
