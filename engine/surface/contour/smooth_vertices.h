// Computes the vertices of smooth patches, one or eight at a time.
#pragma once

#include <glm/glm.hpp>

#include "engine/surface/contour/moments.h"

namespace typodont::surface {

/// Returns the vertex of a smooth block of side s, relative to the block's middle, voxels. The mean of the crossings
/// is not on a curved surface. Its distance from the surface, half the covariance of points and normals, is removed.
glm::vec3 smooth_vertex(const CrossingSums& sums, float s);

/// Vertices of eight cells, as arrays of coordinates.
struct SmoothVertices {
  alignas(32) float position[3][8];  // voxels, relative to the middle of the cell
  alignas(32) float normal[3][8];    // unit normals
};
/// Computes smooth_vertex() with s = 1 and unit_normal() for eight cells, with bit-identical results.
void smooth_vertices(const CrossingSums* const sums[8], SmoothVertices& out);

/// Returns the mean normal of the crossings as a unit vector, or (0, 0, 1) if it is zero.
glm::vec3 unit_normal(const CrossingSums& sums);

/// Returns a bit per cell, set if its normals vary by `limit` or more.
unsigned spread_of_normals(const CrossingSums* const sums[8], float limit);

}  // namespace typodont::surface
