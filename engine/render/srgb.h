// Conversions of sRGB colours (IEC 61966-2-1).
#pragma once

#include <cmath>

#include "engine/base/pose.h"

namespace typodont::render {

/// Converts sRGB to linear light.
inline dvec3 linear_light(const dvec3& srgb) {
  dvec3 out;
  for (int i = 0; i < 3; ++i) out[i] = srgb[i] <= 0.04045 ? srgb[i] / 12.92 : std::pow((srgb[i] + 0.055) / 1.055, 2.4);
  return out;
}

}  // namespace typodont::render
