// A packing as a picture, for a person to judge: the spheres from outside, and cut open. Set-up time.
#pragma once

#include "engine/contract/sphere_packing.h"
#include "engine/render/picture.h"

namespace typodont {

/// Two views along W's y axis, z up: on the left all spheres, on the right only those behind the middle. Spheres have
/// their tissue's colour. `pixels`: height; the picture is twice as wide.
render::Picture packing_picture(const SpherePacking& packing, const MaterialTable& materials, int pixels);

}  // namespace typodont
