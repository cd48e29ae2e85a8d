// Visible difference of two pictures. Any thread.
#pragma once

#include "engine/base/pose.h"
#include "engine/render/picture.h"

namespace typodont::render {

/// CIEDE2000 (Sharma et al. 2005) of (L*, a*, b*).
double ciede2000(const dvec3& lab_1, const dvec3& lab_2);

/// CIELAB of linear sRGB, 0..1, white (1, 1, 1).
dvec3 lab_of_linear(const dvec3& rgb);

/// Mean over pixels; same size. Symmetric.
double mean_ciede2000(const Picture& a, const Picture& b);

/// Mean LDR-FLIP (Andersson et al. 2020), 0 (equal) to 1. The default is the paper's screen: 0.7 m wide, 3840 pixels,
/// from 0.7 m. Same size. Symmetric.
double mean_flip(const Picture& a, const Picture& b, double pixels_per_degree = 67);

}  // namespace typodont::render
