// The points that represent a large face of a mesh, in addition to its corners.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/pose.h"
#include "haptics/contact/vertex/vertex_head.h"

namespace typodont::haptics::vertex {

inline constexpr int kMaxParts = 64;  // largest number of parts into which an edge of a face is divided

/// Number of equal parts for an edge of length `longest`, at most kMaxParts; no part should be longer than `spacing`.
inline int parts_of(double longest, double spacing) noexcept {
  return std::clamp(static_cast<int>(std::ceil(longest / spacing * (1 - 1e-9))), 1, kMaxParts);
}

/// Divides a triangle into n² equal triangles, and calls use(p, count) for their corners other than a, b and c.
/// `count`: number of small triangles that have a corner at p.
template <class Use>
void each_face_point(const dvec3& a, const dvec3& b, const dvec3& c, int n, Use&& use) {
  for (int u = 0; u <= n; ++u) {
    for (int v = 0; v <= n - u; ++v) {
      const int w = n - u - v;
      if (u == n || v == n || w == n) continue;  // skips the corners of the face
      const dvec3 p = (static_cast<double>(u) * a + static_cast<double>(v) * b + static_cast<double>(w) * c) /
                      static_cast<double>(n);
      use(p, u == 0 || v == 0 || w == 0 ? 3.0 : 6.0);
    }
  }
}

/// Returns true if no corner and no point of each_face_point() is inside the head at X_W.
inline bool is_outside(const VertexHead& head, const Pose& X_W, const dvec3& a, const dvec3& b, const dvec3& c,
                       int n) noexcept {
  const dquat R_TW = glm::conjugate(X_W.R);
  const auto outside = [&](const dvec3& p) { return head.distance(R_TW * (p - X_W.p)) > 0; };
  bool all = outside(a) && outside(b) && outside(c);
  if (all) each_face_point(a, b, c, n, [&](const dvec3& p, double) { all = all && outside(p); });
  return all;
}

}  // namespace typodont::haptics::vertex
