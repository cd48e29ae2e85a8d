// Points where the surface crosses grid edges, with normals.
#pragma once

#include <cstdint>
#include <span>

namespace typodont::surface {

/// A crossing as eight floats, so that moments.h can compute outer products of them.
struct alignas(16) Crossing {
  float point[3];
  float normal[3];
  float curvature;  // mean curvature, 1/voxel, positive if convex; 0 near a crease
  float one = 1;
};

/// An edge of the grid that the surface crosses.
struct GridEdge {
  std::uint16_t sample;  // index of the sample at the start of the edge
  std::uint8_t x, y, z;  // coordinates of the sample at the start of the edge
};

/// Computes the crossings of edges along `axis`. `stride`: strides of `field`; reads samples -1..2 along each edge and
/// along the lines beside it. At creases only samples of one side are used, so that flat faces are exact.
void cross_edges(const float* field, const int stride[3], int axis, std::span<const GridEdge> edges, Crossing* out);

}  // namespace typodont::surface
