// Finds the point nearest to all tangent planes: dual contouring (Ju, Losasso, Schaefer & Warren 2002).
#pragma once

#include <array>
#include <glm/glm.hpp>

#include "engine/surface/contour/crossing.h"

namespace typodont::surface {

/// Sums over the tangent planes of crossings, relative to the centre that was passed to add().
struct PlaneSums {
  double count = 0;
  glm::dvec3 point{0};         // Σ p, sum of the crossings' points
  std::array<double, 6> nn{};  // Σ n nᵀ: xx xy xz yy yz zz
  glm::dvec3 nd{0};            // Σ n (n·p)
  double dd = 0;               // Σ (n·p)²

  void add(const Crossing& crossing, const glm::vec3& centre) {
    const glm::dvec3 n(crossing.normal[0], crossing.normal[1], crossing.normal[2]);
    const glm::dvec3 p = glm::dvec3(crossing.point[0], crossing.point[1], crossing.point[2]) - glm::dvec3(centre);
    const double d = glm::dot(n, p);
    count += 1;
    point += p;
    nn[0] += n.x * n.x;
    nn[1] += n.x * n.y;
    nn[2] += n.x * n.z;
    nn[3] += n.y * n.y;
    nn[4] += n.y * n.z;
    nn[5] += n.z * n.z;
    nd += n * d;
    dd += d * d;
  }
};

struct PlaneFit {
  glm::vec3 point{0};
  float residual = 0;  // voxels, root-mean-square distance of the point from the planes
  /// Shape of the surface: 1: flat, 2: edge, 3: corner.
  int rank = 0;
};

/// Returns the point nearest to all planes; of several such points, the one nearest to the crossings' mean. Uses only
/// directions (eigenvectors) whose eigenvalue exceeds `cutoff` × the largest eigenvalue, at most `most` of them.
PlaneFit fit_planes(const PlaneSums& sums, double cutoff, int most = 3);

}  // namespace typodont::surface
