// Meshes of handpieces (engine/contract/handpiece.h), and the simple shape that casts their shadow.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/contract/handpiece.h"

namespace typodont::render {

/// Vertex in the frame H of the handpiece.
struct HandpieceVertex {
  glm::vec3 p{0}, n{0, 0, 1};  // position (m) and unit normal
  // m, point of the part's centre line. If the part would look too thin, its vertices are moved away from this line.
  glm::vec3 middle{0};
  glm::vec3 around{1, 0, 0};      // unit vector around the part, along brushed grooves
  glm::vec3 color{1};             // colour of the surface in linear light
  glm::vec4 look{0.3f, 0, 1, 0};  // material: roughness, brushed, metal, glow
  // Knurling. x, y: position along the path and around it, m (scaled so that a whole number of grooves fits); z: depth,
  // 0..1.
  glm::vec3 grip{0};
};

/// Cone with round ends: a sphere that moves along a line while its radius changes linearly.
struct RoundCone {
  dvec3 a{0}, b{0};       // m, frame H, centres of the ends
  double ra = 0, rb = 0;  // m, radii of the sphere at a and b
};

struct HandpieceMesh {
  std::vector<HandpieceVertex> vertices;
  std::vector<std::uint32_t> indices;
  RoundCone head, body;  // head: cone around the tool's axis; body: cone around the rest of the handpiece
};

/// Distance between grooves of the knurling, m; the fragment shader changes the normal.
inline constexpr double kKnurlPitch = 0.9e-3;

/// Largest number of triangles; a file with more throws Error.
inline constexpr std::size_t kMaxHandpieceTriangles = 30'000;

/// Makes the mesh. `side`: side of triangles, m. Throws Error for too many triangles.
HandpieceMesh make_handpiece_mesh(const Handpiece& handpiece, double side);

}  // namespace typodont::render
