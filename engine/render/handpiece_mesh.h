// Meshes of handpieces and handles from their data (engine/contract/handpiece.h), and the simple shape that casts their
// shadow.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/contract/handpiece.h"

namespace typodont::render {

/// A vertex of a handpiece. Positions and directions are in frame H of the handpiece.
struct HandpieceVertex {
  glm::vec3 p{0}, n{0, 0, 1};  // position (m) and unit normal in frame H of the handpiece
  // m, point on the part's path; a part that looks too thin in the picture is widened away from this point
  glm::vec3 middle{0};
  glm::vec3 around{1, 0, 0};      // unit vector around the part; brushed grooves run in this direction
  glm::vec3 color{1};             // colour of the surface in linear light
  glm::vec4 look{0.3f, 0, 1, 0};  // x: roughness; y: 1 if brushed; z: 1 if metal; w: glow
  // For the knurl (a pattern of grooves for the fingers). x, y: m, position along the path and around the part; y is
  // scaled so that a whole number of grooves fits around the part. z: depth of the knurl, 0..1
  glm::vec3 grip{0};
};

/// A sphere that moves along a line while its radius changes linearly. This shape casts the shadow.
struct RoundCone {
  dvec3 a{0}, b{0};       // m, frame H of the handpiece, centres of the cone's two ends
  double ra = 0, rb = 0;  // m, radii of the cone at its ends a and b
};

struct HandpieceMesh {
  std::vector<HandpieceVertex> vertices;
  std::vector<std::uint32_t> indices;
  RoundCone head, body;  // `head`: the part around the tool's axis; `body`: all other parts
};

/// Distance between the grooves of a knurl, m. The fragment shader draws the knurl by changing the normal.
inline constexpr double kKnurlPitch = 0.9e-3;

/// Largest number of a handpiece's triangles; a file with more triangles is refused (Error).
inline constexpr std::size_t kMostHandpieceTriangles = 30'000;

/// Makes the mesh of a handpiece. `side`: m, wanted length of the triangles' sides. Throws Error if the handpiece has
/// too many triangles.
HandpieceMesh make_handpiece_mesh(const Handpiece& handpiece, double side);

}  // namespace typodont::render
