// Triangulates the zero surface of a distance field by marching tetrahedra; exact where the field is linear. Vertices
// are on edges between samples, so other fields can be interpolated there.
#pragma once

#include <array>
#include <cstddef>

#include "engine/session/dense_field.h"

namespace typodont::session {

/// A point on the edge between samples i < j: at i for t = 0, at j for t = 1.
struct EdgePoint {
  std::size_t i = 0, j = 0;
  double t = 0;
  glm::dvec3 p{0};  // voxels, position of the point

  /// Interpolates another field at this point. `values`: one float per sample.
  template <class Values>
  double of(const Values& values) const {
    return static_cast<double>(values[i]) + t * (static_cast<double>(values[j]) - static_cast<double>(values[i]));
  }
};
// Vertices are counter-clockwise as seen from outside.
using EdgeTriangle = std::array<EdgePoint, 3>;

/// Calls each(const EdgeTriangle&) for all triangles. All cubes are split along the same diagonal (Kuhn 1960), so the
/// surface has no cracks.
template <class Each>
void each_triangle(const DenseField& field, Each&& each) {
  const glm::ivec3 n = field.size;
  if (n.x < 2 || n.y < 2 || n.z < 2) return;
  // The six tetrahedra of a cube have the corners 0, a, b, 7; the table lists a and b. Corner bits: 4 x, 2 y, 1 z.
  static constexpr int kOrder[6][2] = {{4, 6}, {4, 5}, {2, 6}, {2, 3}, {1, 5}, {1, 3}};
  std::array<std::size_t, 8> offset{};
  for (int k = 0; k < 8; ++k) offset[static_cast<std::size_t>(k)] = field.at((k >> 2) & 1, (k >> 1) & 1, k & 1);

  for (int x = 0; x + 1 < n.x; ++x) {
    for (int y = 0; y + 1 < n.y; ++y) {
      for (int z = 0; z + 1 < n.z; ++z) {
        const std::size_t base = field.at(x, y, z);
        int mask = 0;
        for (std::size_t k = 0; k < 8; ++k) mask |= (field.distance[base + offset[k]] < 0) << k;
        if (mask == 0 || mask == 255) continue;
        for (const auto& order : kOrder) {
          const int corner[4] = {0, order[0], order[1], 7};
          int in[4], out[4], ins = 0, outs = 0;
          for (const int c : corner) {
            if (mask >> c & 1)
              in[ins++] = c;
            else
              out[outs++] = c;
          }
          if (ins == 0 || outs == 0) continue;
          const auto point = [&](int c) { return glm::dvec3(x + ((c >> 2) & 1), y + ((c >> 1) & 1), z + (c & 1)); };
          const auto edge = [&](int a, int b) {
            if (a > b) std::swap(a, b);
            EdgePoint e;
            e.i = base + offset[static_cast<std::size_t>(a)];
            e.j = base + offset[static_cast<std::size_t>(b)];
            const double u = static_cast<double>(field.distance[e.i]), v = static_cast<double>(field.distance[e.j]);
            e.t = u / (u - v);
            e.p = point(a) + e.t * (point(b) - point(a));
            return e;
          };
          glm::dvec3 outward(0);
          for (int k = 0; k < outs; ++k) outward += point(out[k]) / static_cast<double>(outs);
          for (int k = 0; k < ins; ++k) outward -= point(in[k]) / static_cast<double>(ins);
          const auto give = [&](const EdgePoint& a, const EdgePoint& b, const EdgePoint& c) {
            const bool turn = glm::dot(glm::cross(b.p - a.p, c.p - a.p), outward) < 0;
            each(turn ? EdgeTriangle{a, c, b} : EdgeTriangle{a, b, c});
          };
          if (ins == 1) {
            give(edge(in[0], out[0]), edge(in[0], out[1]), edge(in[0], out[2]));
          } else if (outs == 1) {
            give(edge(in[0], out[0]), edge(in[1], out[0]), edge(in[2], out[0]));
          } else {
            const EdgePoint a = edge(in[0], out[0]), b = edge(in[0], out[1]), c = edge(in[1], out[1]),
                            d = edge(in[1], out[0]);
            give(a, b, c);
            give(a, c, d);
          }
        }
      }
    }
  }
}

}  // namespace typodont::session
