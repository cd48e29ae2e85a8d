// Finds the point where the surface crosses an edge between two samples, and the normal at that point, from the
// neighbouring samples.
#pragma once

#include <cstdint>
#include <span>

namespace typodont::surface {

/// Position, unit normal and curvature as eight floats; moments.h sums their outer products.
struct alignas(16) Crossing {
  float point[3];
  float normal[3];
  float curvature;  // mean of the two principal curvatures, 1/voxel, positive if the solid is convex; 0 near a crease
  float one = 1;
};

/// An edge of the grid that the surface crosses.
struct GridEdge {
  std::uint16_t sample;  // index of the sample at the start of the edge
  std::uint8_t x, y, z;  // coordinates of this sample
};

/// Computes the points at which the surface crosses edges along one axis (0, 1 or 2), eight edges at a time. `stride`:
/// strides of the samples of `field` along the three axes. Reads the samples -1..2 along each edge, and the neighbours
/// of both ends across it. Writes one crossing per edge to `out`.
/// In a smooth field, the crossing is computed to second order, and the normal by central differences. A cut makes a
/// crease in the field, at which its slope jumps. Near a crease, only samples on one side of it are used: the field is
/// extrapolated linearly, and the normal is computed on the side on which the gradient has the length 1, as in a
/// distance field. So plane faces are reproduced exactly up to their edges.
void cross_edges(const float* field, const int stride[3], int axis, std::span<const GridEdge> edges, Crossing* out);

}  // namespace typodont::surface
