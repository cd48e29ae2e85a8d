// Draws a packing (tissue as spheres) from outside and as a section, so that a person can check it. Not for the
// servo thread.
#pragma once

#include "engine/contract/sphere_packing.h"
#include "engine/render/picture.h"

namespace typodont {

/// Draws two views along the y axis of frame W, with z up. The left view shows all spheres, the right view only the
/// spheres behind the middle. A sphere has the colour of its tissue. `pixels`: height of the picture, which is twice as
/// wide.
render::Picture packing_picture(const SpherePacking& packing, const MaterialTable& materials, int pixels);

}  // namespace typodont
