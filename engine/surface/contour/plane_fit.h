// Where many tangent planes meet best: the vertex of dual contouring (Ju, Losasso, Schaefer & Warren 2002).
#pragma once

#include <array>
#include <cmath>
#include <glm/glm.hpp>

namespace typodont::surface {

/// Sums over crossings (point x, unit normal n, mean curvature) that add up from cells to blocks of cells. Points are relative to the
/// centre of the cell or block, so that single precision is enough.
struct CrossingSums {
  float count = 0;
  glm::vec3 x{0}, n{0};            // Σx, Σn
  float xx = 0, xn = 0;            // Σ|x|², Σx·n
  std::array<float, 6> nn{};       // Σ n nᵀ: xx xy xz yy yz zz
  glm::vec3 nd{0};                 // Σ n (n·x)
  float dd = 0;                    // Σ (n·x)²
  float curvature = 0;

  void add(const glm::vec3& point, const glm::vec3& normal, float mean_curvature) {
    const float d = glm::dot(point, normal);
    count += 1;
    x += point;
    n += normal;
    xx += glm::dot(point, point);
    xn += d;
    nn[0] += normal.x * normal.x;
    nn[1] += normal.x * normal.y;
    nn[2] += normal.x * normal.z;
    nn[3] += normal.y * normal.y;
    nn[4] += normal.y * normal.z;
    nn[5] += normal.z * normal.z;
    nd += normal * d;
    dd += d * d;
    curvature += mean_curvature;
  }
  /// Adds sums whose centre lies at `shift` from this one's.
  void add(const CrossingSums& o, const glm::vec3& shift) {
    const glm::vec3 nn_shift(o.nn[0] * shift.x + o.nn[1] * shift.y + o.nn[2] * shift.z,
                             o.nn[1] * shift.x + o.nn[3] * shift.y + o.nn[4] * shift.z,
                             o.nn[2] * shift.x + o.nn[4] * shift.y + o.nn[5] * shift.z);
    count += o.count;
    x += o.x + o.count * shift;
    n += o.n;
    xx += o.xx + 2 * glm::dot(o.x, shift) + o.count * glm::dot(shift, shift);
    xn += o.xn + glm::dot(o.n, shift);
    for (std::size_t i = 0; i < 6; ++i) nn[i] += o.nn[i];
    nd += o.nd + nn_shift;
    dd += o.dd + 2 * glm::dot(o.nd, shift) + glm::dot(nn_shift, shift);
    curvature += o.curvature;
  }
};

struct PlaneFit {
  glm::vec3 point{0};
  float residual = 0;  // root mean square distance from the planes
  int rank = 0;        // 1 flat, 2 an edge, 3 a corner
};

/// The point nearest to the crossings' mean among those that fit the planes best; directions that the planes hardly
/// determine (eigenvalue under `cutoff` of the greatest) are left at the mean.
PlaneFit fit_planes(const CrossingSums& sums, double cutoff);

}  // namespace typodont::surface
