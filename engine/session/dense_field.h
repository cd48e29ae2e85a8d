// Distance samples as plain arrays, for scores and pictures. Only TrueDistances has state. Not for the servo thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "engine/contract/field_brick.h"

namespace typodont::session {

/// Voxels, negative inside; z is fastest; sample (0,0,0) is at the frame's origin.
struct DenseField {
  glm::ivec3 size{0};
  std::vector<float> distance;

  std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(x) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size.z) +
           static_cast<std::size_t>(z);
  }
  /// Trilinear at p (voxels); outside, as at the nearest point of the box.
  double sample(const glm::dvec3& p) const;
  /// At p (voxels), not normalised: central differences over `reach` voxels to either side.
  glm::dvec3 gradient(const glm::dvec3& p, double reach = 0.5) const;
};

/// Of a voxel, at the signed distance `distance` (voxels) of its centre.
double fraction_inside(double distance);

/// From a field that is right only near its surface, as after cuts. Closest points pass from voxel to voxel (Danielsson
/// 1980, "Euclidean distance mapping"; here they may lie between voxels). Within 1.8 voxels of the surface nothing
/// changes; without a surface nothing at all. Computed on first reading. One thread at a time.
class TrueDistances {
 public:
  TrueDistances() = default;  // of an empty box
  explicit TrueDistances(DenseField field);
  /// Voxels, by array index.
  float operator[](std::size_t at) const;
  /// As DenseField::sample().
  double sample(const glm::dvec3& p) const;

 private:
  /// Closest point of a voxel beside the surface, and the normal there.
  struct Seed {
    glm::vec3 closest;
    bool has_normal;                   // true: `normal` is computed
    std::optional<glm::dvec3> normal;  // empty: gradient too small
  };
  float computed(std::size_t at) const;
  /// One of the 26 neighbours is on the other side.
  bool is_beside_surface(std::size_t at) const;

  DenseField field_;
  mutable std::vector<Seed> seeds_;
  std::vector<std::uint32_t> nearest_;  // nearest seed per voxel
  std::vector<float> reach_;            // voxels to its closest point
  mutable std::vector<float> known_;    // voxels, as far as read; NaN: not yet
};

/// For all voxels.
DenseField redistanced(const DenseField& field);

/// Array index of the nearest marked voxel; SIZE_MAX if none is marked.
std::vector<std::size_t> nearest_marked(const glm::ivec3& size, const std::vector<bool>& marked);

}  // namespace typodont::session
