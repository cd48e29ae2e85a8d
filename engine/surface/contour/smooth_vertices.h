// Places the vertices of smooth pieces of surface: one vertex, or eight vertices at a time.
#pragma once

#include <glm/glm.hpp>

#include "engine/surface/contour/moments.h"

namespace typodont::surface {

/// Returns the vertex for a smooth piece of surface in a block of cells with the side `s`, relative to the block's
/// middle, in voxels. The vertex starts at the mean of the crossings (the points where the surface crosses the cells'
/// edges). On a curved surface, this mean does not lie on the surface: its distance from the surface is half the
/// covariance of points and normals. The vertex is moved by this distance along the normal.
glm::vec3 smooth_vertex(const CrossingSums& sums, float s);

/// Vertices of eight cells, as arrays of coordinates.
struct SmoothVertices {
  alignas(32) float position[3][8];  // voxels, relative to the middle of the cell
  alignas(32) float normal[3][8];    // unit normals
};
/// Computes smooth_vertex(), with s = 1, and unit_normal() for eight cells at a time, with the same bits.
void smooth_vertices(const CrossingSums* const sums[8], SmoothVertices& out);

/// Returns the unit normal in the direction of the sum of the normals; (0, 0, 1) if this sum is zero.
glm::vec3 unit_normal(const CrossingSums& sums);

/// For eight cells, tests whether the variance of the normals at the cell's crossings is below `limit`. Returns one bit
/// for each cell whose variance is not below.
unsigned spread_of_normals(const CrossingSums* const sums[8], float limit);

}  // namespace typodont::surface
