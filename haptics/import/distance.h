// Distances to a surface from closest points.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "haptics/import/blocks.h"
#include "haptics/import/grid.h"

namespace typodont::haptics::importing {

/// Sample i of one grid at p = offset + scale · i of another.
struct Placement {
  glm::dvec3 offset{0};
  double scale = 1;
};

/// Signed, stored near the surface.
struct DistanceField {
  Sparse<float> distance;  // voxels of the source, negative where phi > 0, within ± band
  // source index space; valid where |distance| < band
  Sparse<glm::vec3> closest;
};

/// To phi = 0 (tricubic, phi > 0 inside) on a grid of `size` at `placement`. Nearest crossing of grid lines, below
/// `exact` refined by Newton (Chopp 2001, "Some improvements of the fast marching method", eq. 4.1); beyond, up to 1/(8
/// exact) voxel too large.
DistanceField signed_distance(const Sparse<float>& phi, const glm::ivec3& size, const Placement& placement, double band,
                              double exact);

struct Triangle {
  glm::dvec3 a, b, c;
};
glm::dvec3 closest_on(const Triangle& t, const glm::dvec3& p);

/// Six times the generalized winding number (Jacobson et al. 2013), along the six axis directions: 6 inside, 0 outside,
/// between near holes. Memory follows the surfaces.
class WindingNumbers {
 public:
  WindingNumbers(std::span<const Triangle> mesh, const glm::ivec3& size);
  /// At x; z fastest.
  std::vector<std::int16_t> slab(int x) const;

 private:
  /// A point where a grid line crosses the mesh.
  struct Crossing {
    float at;    // position along the line's axis
    int leaves;  // +1 leaves, -1 enters in the direction of +axis
  };
  /// Crossings by line, sorted. (u, v) follow the axis cyclically; line k = i · size[v] + j has crossings[first[k]] …
  /// [first[k + 1] − 1].
  struct Lines {
    std::vector<Crossing> crossings;
    std::vector<std::uint32_t> first;
  };
  static Lines lines_along(int axis, std::span<const Triangle> mesh, const glm::ivec3& size);
  std::span<const Crossing> line(int axis, int i, int j) const;

  glm::ivec3 size_;
  std::array<Lines, 3> lines_;
};

/// Blocks (bytes, z fastest) that may be within `reach` voxels.
std::vector<std::uint8_t> blocks_near(std::span<const Triangle> mesh, const glm::ivec3& size, double reach);

/// voxels, 0 … `band`; `band` where not stored.
Sparse<float> unsigned_distance(std::span<const Triangle> mesh, const glm::ivec3& size, double band);

}  // namespace typodont::haptics::importing
