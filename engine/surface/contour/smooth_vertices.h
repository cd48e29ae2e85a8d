// Vertices of smooth patches, one or eight at a time.
#pragma once

#include <glm/glm.hpp>

#include "engine/surface/contour/moments.h"

namespace typodont::surface {

/// Relative to the block's middle, voxels. From the crossings' mean along the normal by half the covariance of points
/// and normals: the mean's distance from a curved surface.
glm::vec3 smooth_vertex(const CrossingSums& sums, float s);

/// Vertices of eight cells, as arrays of coordinates.
struct SmoothVertices {
  alignas(32) float position[3][8];  // voxels, relative to the middle of the cell
  alignas(32) float normal[3][8];    // unit normals
};
/// smooth_vertex() with s = 1, and unit_normal(); the same bits.
void smooth_vertices(const CrossingSums* const sums[8], SmoothVertices& out);

/// (0, 0, 1) for zero.
glm::vec3 unit_normal(const CrossingSums& sums);

/// Bit per cell whose normals vary by `limit` or more.
unsigned spread_of_normals(const CrossingSums* const sums[8], float limit);

}  // namespace typodont::surface
