// What a frame could show at all, and how large: for whoever makes surfaces, so that none is made that nobody sees, and
// none finer than a pixel. Pure functions.
#pragma once

#include <array>
#include <cstdint>

#include "engine/render/renderer.h"

namespace typodont::render {

struct BoxInWorld {
  glm::dvec3 lo, hi;  // m, W
};

/// What an eye sees is where dot(plane, (p, 1)) ≥ 0 for all six (Gribb & Hartmann 2001, depth 0..1).
std::array<glm::dvec4, 6> frustum_planes(const glm::dmat4& clip_from);

/// Whether the frame could show anything of what lies within the box: before an eye, in a mouth mirror's glass that an
/// eye sees, or by the shadow it throws there. Generous: true where it may be.
bool in_sight(const Frame& frame, const BoxInWorld& box);

/// m: what a pixel of a picture so many pixels wide covers of the box where that is nearest to an eye.
double pixel_nearest(const Frame& frame, const BoxInWorld& box, std::uint32_t pixels_across);

}  // namespace typodont::render
