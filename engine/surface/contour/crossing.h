// Where the surface crosses an edge, with its normal.
#pragma once

#include <cstdint>
#include <span>

namespace typodont::surface {

/// Eight floats; moments.h sums their outer products.
struct alignas(16) Crossing {
  float point[3];
  float normal[3];
  float curvature;  // mean, 1/voxel, convex positive; 0 near a crease
  float one = 1;
};

/// An edge of the grid that the surface crosses.
struct GridEdge {
  std::uint16_t sample;  // index of the sample at the start of the edge
  std::uint8_t x, y, z;  // coordinates of this sample
};

/// Edges along `axis`, eight at a time; `stride` of `field`; reads -1..2 along, neighbours across. Second order in a
/// smooth field, normals by central differences. At creases only samples of one side, extrapolated linearly where
/// |gradient| is 1: planes are exact up to their edges.
void cross_edges(const float* field, const int stride[3], int axis, std::span<const GridEdge> edges, Crossing* out);

}  // namespace typodont::surface
