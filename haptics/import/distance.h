// Distances to surfaces on a grid: the closest point, not an approximation that drifts away from the surface.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "haptics/import/blocks.h"
#include "haptics/import/grid.h"

namespace typodont::haptics::importing {

/// Where the samples of a wanted grid lie in the index space of another: p = offset + scale · index.
struct Placement {
  glm::dvec3 offset{0};
  double scale = 1;
};

/// Kept in the blocks near the surface only.
struct DistanceField {
  Sparse<float> distance;     // in units of the source's voxels, negative where phi > 0, clamped to ± band
  Sparse<glm::vec3> closest;  // on the surface, source index space; meaningful where |distance| < band
};

/// Distance to the surface phi = 0 (tricubic interpolation) from every sample of a grid of `size` placed in phi's index
/// space; phi > 0 is inside. Closest points by propagation from the crossings, then, nearer than `exact`, Newton's
/// method on the interpolant after Chopp 2001, "Some improvements of the fast marching method", eq. 4.1: the zero set
/// stays where it is. Beyond `exact` the closest of the crossings stands, which lie about half a voxel apart: the
/// distance is too large by 1/(8 exact) voxel at most, about.
DistanceField signed_distance(const Sparse<float>& phi, const glm::ivec3& size, const Placement& placement, double band,
                              double exact);

struct Triangle {
  glm::dvec3 a, b, c;
};
glm::dvec3 closest_on(const Triangle& t, const glm::dvec3& p);

/// The generalized winding number (Jacobson et al. 2013) of a mesh at every sample, in sixths: the signed crossings of
/// the rays along the six directions of the axes, where the paper takes the mean over all directions. 6 inside a closed
/// mesh, 0 outside, in between near the holes of an open one.
Grid<std::int16_t> winding_sixths(std::span<const Triangle> mesh, const glm::ivec3& size);

/// Distance from every sample to the triangles, at most `band`, never negative.
Grid<float> unsigned_distance(std::span<const Triangle> mesh, const glm::ivec3& size, double band);

}  // namespace typodont::haptics::importing
