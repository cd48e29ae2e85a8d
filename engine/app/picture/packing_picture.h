// Draws a sphere packing from outside and in section, so that a person can check it. Not for the servo thread.
#pragma once

#include "engine/contract/sphere_packing.h"
#include "engine/render/picture.h"

namespace typodont {

/// Draws two views along y of W, with z up: all spheres, and only the spheres behind the
/// packing's middle. `pixels`: height of the picture; the width is twice the height.
render::Picture packing_picture(const SpherePacking& packing, const MaterialTable& materials, int pixels);

}  // namespace typodont
