// Computes distances to a surface from its closest points.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "haptics/import/blocks.h"
#include "haptics/import/grid.h"
#include "haptics/import/mesh.h"

namespace typodont::haptics::importing {

/// Position of a grid in another grid: its sample i lies at p = offset + scale · i.
struct Placement {
  glm::dvec3 offset{0};
  double scale = 1;
};

/// Signed distances, stored near the surface.
struct DistanceField {
  Sparse<float> distance;  // voxels of the source grid, limited to ± band; negative where phi > 0
  // Closest point on the surface, in indices of the source grid; valid where |distance| < band.
  Sparse<glm::vec3> closest;
};

/// Distance to the surface phi = 0 (phi > 0 inside), on a grid of `size` at `placement`. Newton's method refines
/// distances below `exact` (Chopp 2001, eq. 4.1); larger ones are up to 1/(8 exact) voxel too large.
DistanceField signed_distance(const Sparse<float>& phi, const glm::ivec3& size, const Placement& placement, double band,
                              double exact);

/// Six times the generalized winding number of a mesh (Jacobson et al. 2013), from rays along the six axis directions:
/// 6 inside, 0 outside, values between near holes. Memory grows with the surface, not with the box.
class WindingNumbers {
 public:
  WindingNumbers(std::span<const Triangle> mesh, const glm::ivec3& size);
  /// Values in the plane x; z runs fastest.
  std::vector<std::int16_t> slab(int x) const;

 private:
  /// A point where a grid line crosses the mesh.
  struct Crossing {
    float at;    // position along the line's axis
    int leaves;  // +1: the line leaves the mesh towards +axis; -1: it enters
  };
  /// Crossings of the mesh with all grid lines along an axis, sorted. i and j: a line's indices along u and v, the two
  /// following axes. The line k = i · size[v] + j has the crossings first[k] to first[k + 1] − 1.
  struct Lines {
    std::vector<Crossing> crossings;
    std::vector<std::uint32_t> first;
  };
  static Lines lines_along(int axis, std::span<const Triangle> mesh, const glm::ivec3& size);
  std::span<const Crossing> line(int axis, int i, int j) const;

  glm::ivec3 size_;
  std::array<Lines, 3> lines_;
};

/// Marks blocks (one byte each, z runs fastest) that may be within `reach` voxels of the mesh.
std::vector<std::uint8_t> blocks_near(std::span<const Triangle> mesh, const glm::ivec3& size, double reach);

/// Distances to the mesh in voxels, from 0 to `band`; samples that are not stored have `band`.
Sparse<float> unsigned_distance(std::span<const Triangle> mesh, const glm::ivec3& size, double band);

}  // namespace typodont::haptics::importing
