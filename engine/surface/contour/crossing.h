// Where the surface crosses an edge between two samples, and its normal there, from the samples around.
#pragma once

#include <cmath>
#include <glm/glm.hpp>

namespace typodont::surface {

/// Point and unit normal; curvature as below. As eight floats, whose outer products are summed (moments.h).
struct alignas(16) Crossing {
  float point[3];
  float normal[3];
  float curvature;
  float one = 1;
};

struct LocalCrossing {
  float t;           // 0..1 along the edge
  float na, nb, nc;  // unit normal along the edge and the two axes across it
  float curvature;   // mean of the two principal ones, 1/voxel, positive where the solid is convex; 0 beside a crease
};

/// `at` is the sample at the edge's base; a, b, c the strides along and across the edge. Reads -a..2a and ±b, ±c of
/// both ends.
///
/// Where the field is smooth: second-order crossing, central differences. A field after CSG is a maximum or minimum of
/// distances, whose slope jumps at a crease; there the crossing is that of the straight continuation from one side, and
/// the differences are taken on the side where the gradient has length one, as a distance has. So plane faces are met
/// exactly up to their edges.
LocalCrossing cross_edge(const float* at, int a, int b, int c);

}  // namespace typodont::surface
