// Meshes from engine/contract/handpiece.h, and the shape that casts their shadow.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/contract/handpiece.h"

namespace typodont::render {

/// Frame H of the handpiece.
struct HandpieceVertex {
  glm::vec3 p{0}, n{0, 0, 1};  // m, and unit normal
  // m on the path; parts that look too thin are widened away from it
  glm::vec3 middle{0};
  glm::vec3 around{1, 0, 0};      // unit vector around the part, along brushed grooves
  glm::vec3 color{1};             // colour of the surface in linear light
  glm::vec4 look{0.3f, 0, 1, 0};  // roughness, brushed, metal, glow
  // Knurl: x, y: m along the path and around (scaled to a whole number of grooves); z: depth, 0..1
  glm::vec3 grip{0};
};

/// A sphere along a line with a linear radius.
struct RoundCone {
  dvec3 a{0}, b{0};       // m, H, ends
  double ra = 0, rb = 0;  // m, at a and b
};

struct HandpieceMesh {
  std::vector<HandpieceVertex> vertices;
  std::vector<std::uint32_t> indices;
  RoundCone head, body;  // around the tool's axis, and the rest
};

/// m between grooves; the fragment shader changes the normal.
inline constexpr double kKnurlPitch = 0.9e-3;

/// A file with more is refused (Error).
inline constexpr std::size_t kMostHandpieceTriangles = 30'000;

/// `side`: m, of triangles. Throws Error if there are too many.
HandpieceMesh make_handpiece_mesh(const Handpiece& handpiece, double side);

}  // namespace typodont::render
