// A box of distance samples as plain arrays, for scores and pictures. The functions have no state. Do not call them
// on the servo thread.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "engine/contract/field_brick.h"

namespace typodont::session {

/// Signed distances in voxels, negative inside the tissue. z is the fastest index, and sample (0,0,0) lies at the
/// origin of the voxel frame.
struct DenseField {
  glm::ivec3 size{0};
  std::vector<float> distance;

  std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(x) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size.z) +
           static_cast<std::size_t>(z);
  }
  /// Returns the trilinear interpolation of the distance at the point p (voxels). Outside the box, the function returns
  /// the value at the nearest point of the box.
  double sample(const glm::dvec3& p) const;
  /// Returns the gradient of the distance at the point p (voxels), not normalised. It is computed by central
  /// differences of interpolated values at `reach` voxels to either side of p.
  glm::dvec3 gradient(const glm::dvec3& p, double reach = 0.5) const;
};

/// Returns the fraction of a voxel's volume that lies inside a surface at the signed distance `distance` (voxels) from
/// the voxel's centre.
double fraction_inside(double distance);

/// Computes true distances from a field that is correct only near its surface, as a field is after cuts. The closest
/// surface points are passed from voxel to voxel (Danielsson 1980, "Euclidean distance mapping"; here these points may
/// lie between voxels). Samples within 1.8 voxels of the surface do not change. A field without a surface is returned
/// unchanged.
DenseField redistanced(const DenseField& field);

/// Returns for every voxel the array index of the nearest marked voxel. If no voxel is marked, every value is SIZE_MAX.
std::vector<std::size_t> nearest_marked(const glm::ivec3& size, const std::vector<bool>& marked);

}  // namespace typodont::session
