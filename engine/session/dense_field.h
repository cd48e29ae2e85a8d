// A box of distance samples as plain arrays, with the functions for scores and pictures. Pure functions; set-up time.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "engine/contract/field_brick.h"

namespace typodont::session {

/// Signed distances in voxels, negative inside the tissue; z is the fastest index. Sample (0,0,0) lies at the frame's
/// origin.
struct DenseField {
  glm::ivec3 size{0};
  std::vector<float> distance;

  std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(x) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size.z) +
           static_cast<std::size_t>(z);
  }
  /// Trilinear interpolation. Outside the box the function returns the value at the box's border.
  double sample(const glm::dvec3& p) const;
  /// Gradient of the trilinear field by central differences over `reach` voxels to either side; not normalised.
  glm::dvec3 gradient(const glm::dvec3& p, double reach = 0.5) const;
};

/// Fraction of a voxel inside a surface at `distance` voxels from its centre.
double fraction_inside(double distance);

/// Computes true distances from a field that is correct only near its surface, like the field after cuts. The closest
/// surface points are propagated from voxel to voxel (Danielsson 1980, "Euclidean distance mapping"; here with points
/// between the voxels). Samples within 1.8 voxels of the surface keep their bits. A field without surface is returned
/// unchanged.
DenseField redistanced(const DenseField& field);

/// For every voxel the array index of the nearest marked voxel; SIZE_MAX everywhere if no voxel is marked.
std::vector<std::size_t> nearest_marked(const glm::ivec3& size, const std::vector<bool>& marked);

}  // namespace typodont::session
