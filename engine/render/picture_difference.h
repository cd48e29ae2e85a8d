// Measures of the visible difference between two pictures. Any thread.
#pragma once

#include "engine/base/pose.h"
#include "engine/render/picture.h"

namespace typodont::render {

/// Returns the colour difference CIEDE2000 (Sharma et al. 2005) of two CIELAB colours (L*, a*, b*).
double ciede2000(const dvec3& lab_1, const dvec3& lab_2);

/// Returns the CIELAB colour of a colour in linear sRGB, 0..1, for the white (1, 1, 1).
dvec3 lab_of_linear(const dvec3& rgb);

/// Returns the mean CIEDE2000 of the pixels of two pictures of the same size. Symmetric.
double mean_ciede2000(const Picture& a, const Picture& b);

/// Returns the mean LDR-FLIP (Andersson et al. 2020), 0 (equal) to 1. `pixels_per_degree`: resolution in the viewer's
/// field of view. The default of 67 is the value of the paper's screen, which is 0.7 m wide with 3840 pixels, seen from
/// 0.7 m. The pictures must have the same size. Symmetric.
double mean_flip(const Picture& a, const Picture& b, double pixels_per_degree = 67);

}  // namespace typodont::render
