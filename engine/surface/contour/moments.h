// What is known of the crossings in a cell or a block of cells: sums that add up, and what follows from them.
#pragma once

#include <array>
#include <cmath>
#include <glm/glm.hpp>

#include "engine/surface/contour/crossing.h"

namespace typodont::surface {

/// Sums over crossings (point p, unit normal n, mean curvature H) of the outer product of (p, 1) and (p, n, H, 1).
/// Points are relative to the centre of the cell or block, so that single precision is enough.
struct alignas(32) Moments {
  float m[4][8] = {};

  void add(const Crossing& crossing, const glm::vec3& centre) {
    alignas(32) float q[8];
    for (int j = 0; j < 3; ++j) q[j] = crossing.point[j] - centre[j];
    for (int j = 0; j < 3; ++j) q[3 + j] = crossing.normal[j];
    q[6] = crossing.curvature;
    q[7] = 1;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 8; ++j) m[i][j] += q[i] * q[j];
    }
    for (int j = 0; j < 8; ++j) m[3][j] += q[j];
  }
  /// Adds moments whose centre lies at `shift` from this one's.
  void add(const Moments& o, const glm::vec3& shift) {
    float moved[4][8];
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 8; ++j) moved[i][j] = o.m[i][j] + (i < 3 ? shift[i] * o.m[3][j] : 0);
    }
    for (int i = 0; i < 4; ++i) {
      const float by = moved[i][7];
      for (int j = 0; j < 3; ++j) moved[i][j] += shift[j] * by;
      for (int j = 0; j < 8; ++j) m[i][j] += moved[i][j];
    }
  }

  float count() const { return m[3][7]; }
  glm::vec3 points() const { return {m[3][0], m[3][1], m[3][2]}; }    // Σ p
  glm::vec3 normals() const { return {m[3][3], m[3][4], m[3][5]}; }   // Σ n
  float curvatures() const { return m[3][6]; }                        // Σ H
  float points_by_normals() const { return m[0][3] + m[1][4] + m[2][5]; }  // Σ p·n
};

/// The greatest principal curvature (absolute) that makes normals change with place as they do in the block. In a
/// direction in which the points spread by less than `least` (a variance) the mean curvature of the crossings stands in.
float greatest_curvature(const Moments& moments, float least);

}  // namespace typodont::surface
