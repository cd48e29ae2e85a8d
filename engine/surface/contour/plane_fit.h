// Fits the point that is nearest to all tangent planes: the vertex of dual contouring (Ju, Losasso, Schaefer & Warren
// 2002).
#pragma once

#include <array>
#include <glm/glm.hpp>

#include "engine/surface/contour/crossing.h"

namespace typodont::surface {

/// Sums over the tangent planes of crossings. Points are relative to the centre that is passed to add().
struct PlaneSums {
  double count = 0;
  glm::dvec3 point{0};         // Σ p, sum of the crossings' points
  std::array<double, 6> nn{};  // Σ n nᵀ, sum of the outer products of the normals, in the order xx xy xz yy yz zz
  glm::dvec3 nd{0};  // Σ n (n·p), sum of the normals, each multiplied by the plane's distance n·p from the centre
  double dd = 0;     // Σ (n·p)², sum of the squared distances of the planes from the centre

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
  /// number of directions that the planes determine: 1 on a flat surface, 2 on an edge, 3 in a corner
  int rank = 0;
};

/// Among the points that fit the planes best, returns the point nearest to the mean of the crossings. Only directions
/// with a large eigenvalue are determined by the planes: the eigenvalue must be at least `cutoff` times the largest
/// eigenvalue, and it must be one of the `most` largest ones. In all other directions, the point has the coordinate of
/// the mean.
PlaneFit fit_planes(const PlaneSums& sums, double cutoff, int most = 3);

}  // namespace typodont::surface
