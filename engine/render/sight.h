// What a frame can show, and a pixel's size there: the mesher builds nothing invisible or finer. Pure functions.
#pragma once

#include <array>
#include <cstdint>

#include "engine/render/renderer.h"

namespace typodont::render {

struct BoxInWorld {
  glm::dvec3 lo, hi;  // m, W
};

/// Visible: dot(plane, (p, 1)) ≥ 0 for all six (Gribb & Hartmann 2001, depth 0..1).
std::array<glm::dvec4, 6> frustum_planes(const glm::dmat4& clip_from);

/// Directly, in the mouth mirror, or by its shadow. May err towards true.
bool in_sight(const Frame& frame, const BoxInWorld& box);

/// m, at the box's point nearest to an eye. `pixels_across`: of the picture.
double pixel_nearest(const Frame& frame, const BoxInWorld& box, std::uint32_t pixels_across);

}  // namespace typodont::render
