// A packing from outside and as section, to be checked by eye. Not for the servo thread.
#pragma once

#include "engine/contract/sphere_packing.h"
#include "engine/render/picture.h"

namespace typodont {

/// Along y of W, z up: all spheres, and those behind the middle. `pixels`: height; twice as wide.
render::Picture packing_picture(const SpherePacking& packing, const MaterialTable& materials, int pixels);

}  // namespace typodont
