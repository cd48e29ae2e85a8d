#include "engine/render/mirror.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"

namespace typodont::render {

glm::dmat4 reflection_in(const Pose& X_WM) {
  const dvec3 n = X_WM.rotate({0, 0, 1});
  glm::dmat4 m(1.0);
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) m[column][row] -= 2 * n[row] * n[column];
  m[3] = glm::dvec4(2 * glm::dot(n, X_WM.p) * n, 1);
  return m;
}

Eye reflected(const Eye& eye, const Pose& X_WM) {
  const glm::dmat4 m = reflection_in(X_WM);
  return {eye.view * m, eye.projection, dvec3(m * glm::dvec4(eye.position, 1)), !eye.flip};
}

glm::dvec4 before_glass(const Pose& X_WM) {
  const dvec3 n = X_WM.rotate({0, 0, 1});
  return {n, -glm::dot(n, X_WM.p)};
}

std::optional<PixelBox> glass_in(const Eye& eye, const MouthMirror& mirror, const glm::ivec2& size) {
  const Pose& X_WM = mirror.X_WM;
  if (mirror.diameter <= 0 || glm::dot(before_glass(X_WM), glm::dvec4(eye.position, 1)) <= 0) return {};
  const glm::dmat4 clip_from_mirror = [&] {
    glm::dmat4 m(glm::mat3_cast(X_WM.R));
    m[3] = glm::dvec4(X_WM.p, 1);
    return eye.projection * eye.view * m;
  }();
  // Projects the corners of an octagon around the glass to the picture.
  constexpr int kCorners = 8;
  const double r = 0.5 * mirror.diameter / std::cos(kPi / kCorners);
  glm::dvec2 lo(1e9), hi(-1e9);
  double nearest = 1e9;
  for (int i = 0; i < kCorners; ++i) {
    const double a = 2 * kPi * i / kCorners;
    const glm::dvec4 q = clip_from_mirror * glm::dvec4(r * std::cos(a), r * std::sin(a), 0, 1);
    nearest = std::min(nearest, q.w);
    const glm::dvec2 p = glm::dvec2(q) / std::max(q.w, 1e-9);
    lo = glm::min(lo, p);
    hi = glm::max(hi, p);
  }
  // If part of the disc is behind the eye, the box is the whole picture.
  if (nearest <= 1e-6) return PixelBox{0, 0, size.x, size.y};
  const glm::dvec2 scale = 0.5 * glm::dvec2(size);
  const glm::ivec2 first = glm::clamp(glm::ivec2(glm::floor((lo + 1.0) * scale)) - 1, glm::ivec2(0), size);
  const glm::ivec2 last = glm::clamp(glm::ivec2(glm::ceil((hi + 1.0) * scale)) + 1, glm::ivec2(0), size);
  if (first.x >= last.x || first.y >= last.y) return {};
  return PixelBox{first.x, first.y, last.x - first.x, last.y - first.y};
}

ToolMesh make_mirror_body(double diameter) {
  const double r = diameter / 2;
  ToolMesh mesh;
  // The mirror's body: a shallow cup, whose rim is slightly higher than the glass.
  add_lathe(mesh,
            {{0, -1.6e-3},
             {0.55 * r, -1.5e-3},
             {0.85 * r, -1.2e-3},
             {r + 0.2e-3, -0.6e-3},
             {r + 0.45e-3, 0},
             {r + 0.30e-3, 0.22e-3},
             {r, 0.20e-3},
             {r - 0.05e-3, 0.02e-3}},
            64, 0.20f);
  // The handle: from behind the rim along (1, 0, 1)/√2.
  const std::size_t first = mesh.vertices.size();
  add_lathe(mesh,
            {{0, -1e-3},
             {1.1e-3, -0.8e-3},
             {1.1e-3, 2e-3},
             {1.0e-3, 18e-3},
             {1.3e-3, 24e-3},
             {2.6e-3, 30e-3},
             {3.0e-3, 34e-3},
             {3.0e-3, 100e-3},
             {2.4e-3, 102e-3},
             {0, 102e-3}},
            32, 0.26f);
  const dvec3 handle(std::sqrt(0.5), 0, std::sqrt(0.5));
  const dquat R = rotation_between({0, 0, 1}, handle);
  const dvec3 root(r + 0.6e-3, 0, -0.6e-3);
  for (std::size_t i = first; i < mesh.vertices.size(); ++i) {
    ToolVertex& v = mesh.vertices[i];
    v.p = v.hull_p = glm::vec3(root + R * dvec3(v.p));
    v.n = v.hull_n = glm::vec3(R * dvec3(v.n));
  }
  for (ToolVertex& v : mesh.vertices) v.spins = 0;
  return mesh;
}

}  // namespace typodont::render
