#include "engine/surface/contour/moments.h"

#include <cmath>

namespace typodont::surface {

float max_curvature(const Moments& moments, float least) {
  const CrossingSums sums = moments.sums();
  const float w = 1 / sums.count(), mean_curvature = sums.curvatures() * w;
  const glm::vec3 x = sums.points() * w, n = sums.normals() * w;
  const float length = glm::length(n);
  if (length < 1e-6f) return 1;
  const glm::vec3 unit = n / length;
  const glm::vec3 u =
      glm::normalize(std::abs(unit.x) < 0.7f ? glm::vec3(0, -unit.z, unit.y) : glm::vec3(unit.y, -unit.x, 0));
  const glm::vec3 v = glm::cross(unit, u);

  // Mean of (position·a) × (vector·b) over the crossings. With the covariances X of positions and C of normals with
  // positions in the tangent plane, the shape operator is S = C X⁻¹.
  auto product = [&](const glm::vec3& a, int first, const glm::vec3& b) {
    float sum = 0;
    for (int i = 0; i < 3; ++i)
      sum += a[i] * (moments.at(i, first) * b.x + moments.at(i, first + 1) * b.y + moments.at(i, first + 2) * b.z);
    return w * sum;
  };
  auto place = [&](const glm::vec3& a, const glm::vec3& b) {
    return product(a, 0, b) - glm::dot(a, x) * glm::dot(b, x);
  };
  // Covariance of normal·a with position·b.
  auto change = [&](const glm::vec3& a, const glm::vec3& b) {
    return product(b, 3, a) - glm::dot(a, n) * glm::dot(b, x);
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
