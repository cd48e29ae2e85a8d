// Tests what a frame can show at all, and how large, so that the mesher builds no invisible surfaces and none finer
// than a pixel. Pure functions.
#pragma once

#include <array>
#include <cstdint>

#include "engine/render/renderer.h"

namespace typodont::render {

struct BoxInWorld {
  glm::dvec3 lo, hi;  // m, W
};

/// The six planes of the view frustum: visible points have dot(plane, (p, 1)) ≥ 0 for all (Gribb & Hartmann 2001, depth
/// 0..1).
std::array<glm::dvec4, 6> frustum_planes(const glm::dmat4& clip_from);

/// True if the frame may show anything inside the box: directly, in a mouth mirror's glass, or through the shadow that
/// it casts there. May also be true for a box that is invisible.
bool in_sight(const Frame& frame, const BoxInWorld& box);

/// Size in m of a pixel at the point of the box nearest to an eye, in a picture `pixels_across` pixels wide.
double pixel_nearest(const Frame& frame, const BoxInWorld& box, std::uint32_t pixels_across);

}  // namespace typodont::render
