// Meshes of handpieces and handles from their data (engine/contract/handpiece.h), and the simple shape that casts their
// shadow.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/contract/handpiece.h"

namespace typodont::render {

/// A vertex of a handpiece, frame H.
struct HandpieceVertex {
  glm::vec3 p{0}, n{0, 0, 1};     // m
  glm::vec3 middle{0};            // m, point on the part's path; thin parts are widened away from it
  glm::vec3 around{1, 0, 0};      // unit, direction around the part: the direction of its brushed grooves
  glm::vec3 color{1};             // linear light
  glm::vec4 look{0.3f, 0, 1, 0};  // roughness, 1 if brushed, 1 if metal, glow
  // m: position along the path and around the part; y is fitted so that a whole number of knurls goes around. z: depth
  // of the knurl, 0..1
  glm::vec3 grip{0};
};

/// A sphere swept along a line while its radius changes linearly: the shape that casts the shadow.
struct RoundCone {
  dvec3 a{0}, b{0};       // m, H
  double ra = 0, rb = 0;  // m
};

struct HandpieceMesh {
  std::vector<HandpieceVertex> vertices;
  std::vector<std::uint32_t> indices;
  RoundCone head, body;  // the part about the tool's axis, and the rest
};

/// Pitch of a knurl, m. The fragment shader draws it as a bump of the normal.
inline constexpr double kKnurlPitch = 0.9e-3;

/// Triangles of every handpiece stay below this number; a file with more is refused (Error).
inline constexpr std::size_t kMostHandpieceTriangles = 30'000;

/// `side`: m, wanted length of the triangles' sides. Throws Error if the handpiece has too many triangles.
HandpieceMesh make_handpiece_mesh(const Handpiece& handpiece, double side);

}  // namespace typodont::render
