// A box of distance samples as plain arrays, for scores and pictures. Only TrueDistances has a state. Do not use this
// file on the servo thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
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

/// True distances, computed from a field that is correct only near its surface, as a field is after cuts. The closest
/// surface points are passed from voxel to voxel (Danielsson 1980, "Euclidean distance mapping"; here these points may
/// lie between voxels). Samples within 1.8 voxels of the surface do not change. A field without a surface keeps its
/// values. The exact closest point of a voxel is found when the voxel is read for the first time, because most users
/// read few voxels. Only one thread at a time may use an object.
class TrueDistances {
 public:
  TrueDistances() = default;  // of an empty box
  explicit TrueDistances(DenseField field);
  /// Returns the distance (voxels) of the voxel with this array index.
  float operator[](std::size_t at) const;
  /// Returns the trilinear interpolation, as DenseField::sample() does.
  double sample(const glm::dvec3& p) const;

 private:
  /// The closest point on the surface of a voxel next to the surface, and the surface's normal there.
  struct Seed {
    glm::vec3 closest;
    bool has_normal;                   // true: `normal` is computed
    std::optional<glm::dvec3> normal;  // no value if the gradient is too small for a direction
  };
  float computed(std::size_t at) const;

  DenseField field_;
  mutable std::vector<Seed> seeds_;
  std::vector<std::uint32_t> nearest_;  // for each voxel, the index of its nearest seed
  std::vector<float> reach_;            // voxels, for each voxel, the distance to that seed's closest point
  mutable std::vector<float> known_;    // voxels, the distances that were read; NaN: not yet
};

/// Returns the TrueDistances of all voxels as a field.
DenseField redistanced(const DenseField& field);

/// Returns for every voxel the array index of the nearest marked voxel. If no voxel is marked, every value is SIZE_MAX.
std::vector<std::size_t> nearest_marked(const glm::ivec3& size, const std::vector<bool>& marked);

}  // namespace typodont::session
