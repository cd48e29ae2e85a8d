// Finds the point where the surface crosses an edge between two samples, and the normal at that point, from the
// neighbouring samples.
#pragma once

#include <cstdint>
#include <span>

namespace typodont::surface {

/// Position, unit normal and curvature (as in LocalCrossing) as eight floats; moments.h sums their outer products.
struct alignas(16) Crossing {
  float point[3];
  float normal[3];
  float curvature;
  float one = 1;
};

struct LocalCrossing {
  float t;           // 0..1, position of the crossing along the edge of the grid
  float na, nb, nc;  // unit normal: components along the edge and along the two axes across it
  float curvature;   // mean of the two principal curvatures, 1/voxel, positive if the solid is convex; 0 near a crease
};

/// Computes the point at which the surface crosses one edge of the grid. `at`: sample at the start of the edge; a:
/// stride along the edge; b, c: strides across it. Reads the samples -a..2a, and the samples ±b, ±c at both ends.
/// In a smooth field, the crossing is computed to second order, and the normal by central differences. A cut makes a
/// crease in the field, at which its slope jumps. Near a crease, only samples on one side of it are used: the field is
/// extrapolated linearly, and the normal is computed on the side on which the gradient has the length 1, as in a
/// distance field. So plane faces are reproduced exactly up to their edges.
LocalCrossing cross_edge(const float* at, int a, int b, int c);

/// An edge of the grid that the surface crosses.
struct GridEdge {
  std::uint16_t sample;  // index of the sample at the start of the edge
  std::uint8_t x, y, z;  // coordinates of this sample
};

/// Computes the crossings of many edges along one axis (0, 1 or 2), eight edges at a time, with the same bits as
/// cross_edge(). `stride`: strides of the samples of `field` along the three axes. Writes one crossing per edge to
/// `out`.
void cross_edges(const float* field, const int stride[3], int axis, std::span<const GridEdge> edges, Crossing* out);

}  // namespace typodont::surface
