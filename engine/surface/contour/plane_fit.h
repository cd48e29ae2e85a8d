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
  std::array<float, 6> xx{};       // Σ x xᵀ: xx xy xz yy yz zz
  glm::mat3 nx{0};                 // Σ n xᵀ: column j is Σ n x_j
  std::array<float, 6> nn{};       // Σ n nᵀ
  glm::vec3 nd{0};                 // Σ n (n·x)
  float dd = 0;                    // Σ (n·x)²
  float curvature = 0;

  void add(const glm::vec3& point, const glm::vec3& normal, float mean_curvature) {
    const float d = glm::dot(point, normal);
    count += 1;
    x += point;
    n += normal;
    xx[0] += point.x * point.x;
    xx[1] += point.x * point.y;
    xx[2] += point.x * point.z;
    xx[3] += point.y * point.y;
    xx[4] += point.y * point.z;
    xx[5] += point.z * point.z;
    nx[0] += normal * point.x;
    nx[1] += normal * point.y;
    nx[2] += normal * point.z;
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
  float xn() const { return nx[0].x + nx[1].y + nx[2].z; }  // Σ x·n

  /// Adds sums whose centre lies at `shift` from this one's.
  void add(const CrossingSums& o, const glm::vec3& shift) {
    const glm::vec3 nn_shift(o.nn[0] * shift.x + o.nn[1] * shift.y + o.nn[2] * shift.z,
                             o.nn[1] * shift.x + o.nn[3] * shift.y + o.nn[4] * shift.z,
                             o.nn[2] * shift.x + o.nn[4] * shift.y + o.nn[5] * shift.z);
    count += o.count;
    x += o.x + o.count * shift;
    n += o.n;
    const glm::vec3 &p = o.x, &d = shift;
    xx[0] += o.xx[0] + 2 * p.x * d.x + o.count * d.x * d.x;
    xx[1] += o.xx[1] + p.x * d.y + p.y * d.x + o.count * d.x * d.y;
    xx[2] += o.xx[2] + p.x * d.z + p.z * d.x + o.count * d.x * d.z;
    xx[3] += o.xx[3] + 2 * p.y * d.y + o.count * d.y * d.y;
    xx[4] += o.xx[4] + p.y * d.z + p.z * d.y + o.count * d.y * d.z;
    xx[5] += o.xx[5] + 2 * p.z * d.z + o.count * d.z * d.z;
    nx[0] += o.nx[0] + o.n * d.x;
    nx[1] += o.nx[1] + o.n * d.y;
    nx[2] += o.nx[2] + o.n * d.z;
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
/// determine (eigenvalue under `cutoff` of the greatest, or beyond the `most` greatest) are left at the mean.
PlaneFit fit_planes(const CrossingSums& sums, double cutoff, int most = 3);

/// The greatest principal curvature (absolute) that makes normals change with place as they do in the block. In a
/// direction in which the points spread by less than `least` (a variance) the mean curvature of the crossings stands in.
float greatest_curvature(const CrossingSums& sums, float least);

}  // namespace typodont::surface
