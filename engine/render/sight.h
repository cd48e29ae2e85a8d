// Finds what a frame can show, and the size of a pixel there, so that the mesher builds nothing invisible or
// unnecessarily fine. Pure functions.
#pragma once

#include <array>
#include <cstdint>

#include "engine/render/renderer.h"

namespace typodont::render {

struct BoxInWorld {
  glm::dvec3 lo, hi;  // m, frame W, lower and upper corner
};

/// Planes of the frustum; a point is visible if dot(plane, (p, 1)) ≥ 0 for all six (Gribb & Hartmann 2001, depth 0..1).
std::array<glm::dvec4, 6> frustum_planes(const glm::dmat4& clip_from);

/// Returns true if a box may be visible: directly, in the mouth mirror, or by its shadow. May wrongly return true.
bool in_sight(const Frame& frame, const BoxInWorld& box);

/// Size of a pixel at the point of the box nearest to an eye, m. `pixels_across`: width of the picture, pixels.
double pixel_nearest(const Frame& frame, const BoxInWorld& box, std::uint32_t pixels_across);

}  // namespace typodont::render
