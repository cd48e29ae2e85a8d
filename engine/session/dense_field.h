// Distance fields as plain arrays, for scores and pictures. TrueDistances caches its results. Not for the servo thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "engine/base/voxels.h"
#include "engine/contract/field_brick.h"

namespace typodont::session {

/// Signed distances in voxels, negative inside; z changes fastest. Sample (0,0,0) is at the frame's origin.
struct DenseField {
  glm::ivec3 size{0};
  std::vector<float> distance;

  std::size_t at(int x, int y, int z) const { return voxel_index({x, y, z}, size); }
  /// Trilinear interpolation at p (voxels). Outside of the box: the value at the nearest point of the box.
  double sample(const glm::dvec3& p) const;
  /// Gradient at p (voxels), not normalised: central differences over `reach` voxels to either side.
  glm::dvec3 gradient(const glm::dvec3& p, double reach = 0.5) const;
};

/// Fraction of a voxel that is inside the surface. `distance`: signed distance of the voxel's centre, voxels.
double fraction_inside(double distance);

/// Corrects a distance field that is exact only near its surface, for example after cuts. Passes closest points from
/// voxel to voxel (Danielsson 1980, "Euclidean distance mapping"; here, the points may be between voxels).
/// Distances within 1.8 voxels of the surface do not change; a field without surface does not change at all. Each
/// distance is computed when it is first read. Any number of threads may read.
class TrueDistances {
 public:
  TrueDistances() = default;  // an empty box
  explicit TrueDistances(DenseField field);
  /// Distance in voxels. `at`: array index.
  float operator[](std::size_t at) const;
  /// Interpolates the distances as DenseField::sample() does.
  double sample(const glm::dvec3& p) const;
  /// Computes all distances, on several threads.
  DenseField all() &&;

 private:
  /// The surface point nearest to a voxel beside the surface, and the normal there.
  struct Seed {
    glm::vec3 closest;
    enum State : std::uint8_t { kNone, kWritten, kKnown };
    State state = kNone;               // of `normal`: no value, a thread writes it, valid
    std::optional<glm::dvec3> normal;  // normal at `closest`; empty: the gradient is too small
  };
  std::optional<glm::dvec3> normal_of(Seed& seed) const;
  float computed(std::size_t at) const;
  /// True if one of the 26 neighbours is on the other side of the surface.
  bool is_beside_surface(std::size_t at) const;

  DenseField field_;
  mutable std::vector<Seed> seeds_;
  std::vector<std::uint32_t> nearest_;  // for each voxel: index in `seeds_` of the nearest voxel beside the surface
  std::vector<float> reach_;            // voxels, distance of each voxel from the surface point of the nearest seed
  mutable std::vector<float> known_;    // voxels, distances that were already read; NaN: not yet
};

/// Copy of `field` in which each voxel has its true distance to the surface of `field` (class TrueDistances).
DenseField redistanced(const DenseField& field);

/// For each voxel: array index of the nearest marked voxel. SIZE_MAX if none is marked.
std::vector<std::size_t> nearest_marked(const glm::ivec3& size, const std::vector<bool>& marked);

}  // namespace typodont::session
