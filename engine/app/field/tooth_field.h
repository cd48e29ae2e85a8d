// A copy of a whole volume as plain arrays. It can be sampled at any point. Used for pictures; built before a session,
// or when a view is requested.
#pragma once

#include <array>
#include <vector>

#include "engine/contract/field_brick.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class ToothField {
 public:
  /// Copies the volume, which stores distances only in a band around the surface. Outside the tissue, distances up to
  /// `reach` (m) beyond this band are computed, with an error of a few percent.
  explicit ToothField(const haptics::TissueVolume& volume, double reach = 0);

  /// Returns the lower corner (m, frame W) of the box that contains the surface and all distances that the volume
  /// stores.
  const dvec3& low() const { return low_; }
  const dvec3& high() const { return high_; }
  double voxel() const { return frame_.voxel; }

  /// Returns the signed distance from the position to the surface, m, negative inside. It is interpolated linearly
  /// between samples. If no surface is near, returns the largest computed distance.
  double distance(const dvec3& p_W) const;
  Tissue tissue(const dvec3& p_W) const;
  /// Returns the tissue directly below the surface point that is nearest to the position.
  Tissue tissue_at_surface(const dvec3& p_W) const;
  /// Returns the fraction of each tissue around the position, 0..1: the labels of neighbouring voxels, weighted by a
  /// cubic B-spline.
  std::array<double, kTissueCount> fractions(const dvec3& p_W) const;

 private:
  void extend();
  std::size_t index(const glm::ivec3& i) const {
    return (static_cast<std::size_t>(i.x) * size_.y + static_cast<std::size_t>(i.y)) * size_.z +
           static_cast<std::size_t>(i.z);
  }
  VoxelFrame frame_;
  double band_, reach_;
  glm::ivec3 lo_{0}, size_{0};
  std::vector<float> distance_;
  std::vector<Tissue> tissue_;
  dvec3 low_{0}, high_{0};
};

}  // namespace typodont
