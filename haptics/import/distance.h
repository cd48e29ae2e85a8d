// Distances from the samples of a grid to a surface, computed from closest points.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "haptics/import/blocks.h"
#include "haptics/import/grid.h"

namespace typodont::haptics::importing {

/// Position of one grid in the index space of another grid: the sample of the first grid with the index i lies at the
/// index p = offset + scale · i of the second grid.
struct Placement {
  glm::dvec3 offset{0};
  double scale = 1;
};

/// A signed distance field, stored only in the blocks near the surface.
struct DistanceField {
  Sparse<float> distance;  // distance in voxels of the source grid, negative where phi > 0, clamped to ± band
  // closest point of the surface, in the source's index space; valid where |distance| < band
  Sparse<glm::vec3> closest;
};

/// Computes the distance to the surface phi = 0 (tricubic interpolation; phi > 0 is inside) for every sample of a grid
/// of `size`, whose position in phi's index space is `placement`. First, each sample gets the distance to the nearest
/// crossing: the nearest point where a grid line crosses the surface. If this distance is less than `exact`, Newton's
/// method then finds the closest point of the interpolant (after Chopp 2001, "Some improvements of the fast marching
/// method", eq. 4.1), so that the surface does not move. Larger distances are not improved. They are too large by at
/// most about 1/(8 exact) voxel, because crossings are about half a voxel apart.
DistanceField signed_distance(const Sparse<float>& phi, const glm::ivec3& size, const Placement& placement, double band,
                              double exact);

struct Triangle {
  glm::dvec3 a, b, c;
};
glm::dvec3 closest_on(const Triangle& t, const glm::dvec3& p);

/// Computes the generalized winding number (Jacobson et al. 2013) of a mesh at the samples of a grid, multiplied by
/// six. It is the sum of the signed crossings of rays in the six axis directions, whereas Jacobson et al. take the mean
/// over all directions. The value is 6 inside a closed mesh, 0 outside, and between 0 and 6 near the holes of an open
/// mesh. The memory is proportional to the area of the surface and of the grid's outer faces.
class WindingNumbers {
 public:
  WindingNumbers(std::span<const Triangle> mesh, const glm::ivec3& size);
  /// Returns six times the winding number for each sample with the given x; z is the fastest index.
  std::vector<std::int16_t> slab(int x) const;

 private:
  /// A point where a grid line crosses the mesh.
  struct Crossing {
    float at;    // position along the line's axis
    int leaves;  // 1 if the line, in the direction of +axis, leaves the mesh here; -1 if it enters the mesh
  };
  /// The crossings of all grid lines along one axis: line by line, and along each line sorted by position. u and v are
  /// the two axes that follow in the cycle x, y, z, x. The line at (u, v) = (i, j) has the index k = i · size[v] + j,
  /// and its crossings are crossings[first[k]] to crossings[first[k + 1] − 1].
  struct Lines {
    std::vector<Crossing> crossings;
    std::vector<std::uint32_t> first;
  };
  static Lines lines_along(int axis, std::span<const Triangle> mesh, const glm::ivec3& size);
  std::span<const Crossing> line(int axis, int i, int j) const;

  glm::ivec3 size_;
  std::array<Lines, 3> lines_;
};

/// Marks the blocks of a grid of `size` that may contain samples nearer than `reach` (voxels) to a triangle. The result
/// has one byte per block (z fastest).
std::vector<std::uint8_t> blocks_near(std::span<const Triangle> mesh, const glm::ivec3& size, double reach);

/// Returns the distance (voxels) from every sample to the nearest triangle, from 0 to `band`. Samples that are not
/// stored have the distance `band`.
Sparse<float> unsigned_distance(std::span<const Triangle> mesh, const glm::ivec3& size, double band);

}  // namespace typodont::haptics::importing
