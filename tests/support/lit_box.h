// Bodies of a few triangles for tests of the light in a mouth.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "engine/render/light_scene.h"

namespace typodont::test {

/// Adds a plate of two triangles of this colour. Its front is the side from which a, b, c, d run counter-clockwise.
/// `free_path`: m, mean free path of light in its tissue; 0: opaque.
inline void add_plate(std::vector<render::LitTriangle>& all, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c,
                      const glm::vec3& d, const glm::vec3& color, float free_path = 0) {
  const glm::vec3 n = glm::normalize(glm::cross(b - a, c - a));
  for (const auto& corners : {std::array{a, b, c}, std::array{a, c, d}})
    all.push_back({.corners = corners, .color = color, .normals = {n, n, n}, .free_path = glm::vec3(free_path)});
}
/// Adds the six sides of a box, whose front is outside.
inline void add_box(std::vector<render::LitTriangle>& all, const glm::vec3& lo, const glm::vec3& hi,
                    const glm::vec3& color, float free_path = 0) {
  const auto at = [&](int x, int y, int z) { return glm::vec3(x ? hi.x : lo.x, y ? hi.y : lo.y, z ? hi.z : lo.z); };
  add_plate(all, at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1), color, free_path);
  add_plate(all, at(0, 1, 0), at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), color, free_path);
  add_plate(all, at(1, 1, 0), at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), color, free_path);
  add_plate(all, at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1), color, free_path);
  add_plate(all, at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1), color, free_path);
  add_plate(all, at(0, 1, 0), at(1, 1, 0), at(1, 0, 0), at(0, 0, 0), color, free_path);
}

}  // namespace typodont::test
