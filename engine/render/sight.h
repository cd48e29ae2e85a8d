// Tests whether a frame can show an object, and computes the size of a pixel on the object. The mesher uses these
// results: it builds no surface that is invisible, and none that is finer than a pixel. Pure functions.
#pragma once

#include <array>
#include <cstdint>

#include "engine/render/renderer.h"

namespace typodont::render {

struct BoxInWorld {
  glm::dvec3 lo, hi;  // m, frame W, corners of the box: least and greatest coordinates
};

/// Returns the six planes of the view frustum. A visible point has dot(plane, (p, 1)) ≥ 0 for all planes (Gribb &
/// Hartmann 2001, depth 0..1).
std::array<glm::dvec4, 6> frustum_planes(const glm::dmat4& clip_from);

/// Returns true if the frame may show the box: directly, in the mouth mirror, or by the box's shadow. May also return
/// true for a box that is invisible.
bool in_sight(const Frame& frame, const BoxInWorld& box);

/// Returns the size of a pixel (m) at the point of the box that is nearest to an eye. The picture is `pixels_across`
/// pixels wide.
double pixel_nearest(const Frame& frame, const BoxInWorld& box, std::uint32_t pixels_across);

}  // namespace typodont::render
