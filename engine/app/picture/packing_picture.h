// Draws a packing for visual inspection, from outside and as a section. Set-up time.
#pragma once

#include "engine/contract/sphere_packing.h"
#include "engine/render/picture.h"

namespace typodont {

/// Draws two views along W's y axis, with z up. Left: all spheres; right: only the spheres behind the middle. Spheres
/// have the colour of their tissue. `pixels`: height; the picture is twice as wide.
render::Picture packing_picture(const SpherePacking& packing, const MaterialTable& materials, int pixels);

}  // namespace typodont
