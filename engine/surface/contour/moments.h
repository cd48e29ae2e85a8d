// Sums over crossings of grid edges with the surface, from which vertices and curvatures follow. The sums of two sets
// of crossings can be added.
#pragma once

#include <cstring>
#include <glm/glm.hpp>

#include "engine/base/vectors.h"
#include "engine/surface/contour/crossing.h"

namespace typodont::surface {

/// Sums over the points where the surface crosses grid edges: point p, unit normal n, mean curvature H. p is
/// relative to the cell's centre, so that the precision of floats suffices.
struct CrossingSums {
  Four low = {}, high = {};  // Σ (p.x p.y p.z n.x), Σ (n.y n.z H 1) of crossings: point p, normal n, mean curvature H
  Four by_normals = {};      // Σ (p.x·n.x, p.y·n.y, p.z·n.z); the last lane has no meaning

  void add(const Crossing& crossing, const glm::vec3& centre) {
    Four first, second, normal;
    std::memcpy(&first, crossing.point, sizeof first);
    std::memcpy(&second, crossing.normal + 1, sizeof second);
    std::memcpy(&normal, crossing.normal, sizeof normal);
    first -= Four{centre.x, centre.y, centre.z, 0};
    low += first;
    high += second;
    by_normals += first * normal;
  }

  float count() const { return high[3]; }
  glm::vec3 points() const { return {low[0], low[1], low[2]}; }     // returns Σ p, the sum of the crossings' points
  glm::vec3 normals() const { return {low[3], high[0], high[1]}; }  // returns Σ n, the sum of the crossings' normals
  float curvatures() const { return high[2]; }  // returns Σ H, the sum of the crossings' mean curvatures
};

/// Sums Σ (p, 1) ⊗ (p, n, H, 1) over crossings (point p, normal n, mean curvature H), to compute curvatures.
struct Moments {
  Four m[4][2] = {};  // row i < 3: Σ p_i · (p.x p.y p.z n.x | n.y n.z H 1) of crossings; row 3: Σ without p_i

  void add(const Crossing& crossing, const glm::vec3& centre) {
    Four low, high;
    std::memcpy(&low, crossing.point, sizeof low);
    std::memcpy(&high, crossing.normal + 1, sizeof high);
    low -= Four{centre.x, centre.y, centre.z, 0};
    for (int i = 0; i < 3; ++i) {
      m[i][0] += low[i] * low;
      m[i][1] += low[i] * high;
    }
    m[3][0] += low;
    m[3][1] += high;
  }
  /// Adds the moments `o`, whose centre lies at `shift` from the centre of these moments.
  void add(const Moments& o, const glm::vec3& shift) {
    const Four by{shift.x, shift.y, shift.z, 0};
    for (int i = 0; i < 4; ++i) {
      Four low = o.m[i][0], high = o.m[i][1];
      if (i < 3) {
        low += shift[i] * o.m[3][0];
        high += shift[i] * o.m[3][1];
      }
      m[i][0] += low + high[3] * by;
      m[i][1] += high;
    }
  }

  float at(int i, int j) const { return m[i][j >> 2][j & 3]; }
  CrossingSums sums() const { return {m[3][0], m[3][1], Four{at(0, 3), at(1, 4), at(2, 5), 0}}; }
};

/// Returns the largest curvature, from the change of normals. Where the variance of the points is below `least`, the
/// mean curvature of the crossings is used.
float max_curvature(const Moments& moments, float least);

}  // namespace typodont::surface
