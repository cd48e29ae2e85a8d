// A whole volume as arrays that can be sampled at any point. For pictures, before a session or on request.
#pragma once

#include <array>
#include <vector>

#include "engine/base/voxels.h"
#include "engine/contract/field_brick.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class ToothField {
 public:
  /// Copies the volume. Outside the tissue, adds distances up to `reach` (m) beyond the stored ones, exact within a few
  /// percent.
  explicit ToothField(const haptics::TissueVolume& volume, double reach = 0);

  /// Box around surface and stored distances, m, frame W.
  const dvec3& low() const { return low_; }
  const dvec3& high() const { return high_; }
  double voxel() const { return frame_.voxel; }

  /// Signed distance, m, negative inside, interpolated linearly. If no surface is near: the largest computed distance.
  double distance(const dvec3& p_W) const;
  Tissue tissue(const dvec3& p_W) const;
  /// Tissue just below the nearest point of the surface.
  Tissue tissue_at_surface(const dvec3& p_W) const;
  /// Fraction of each tissue around the point, 0 to 1: labels weighted by a cubic B-spline.
  std::array<double, kTissueCount> fractions(const dvec3& p_W) const;

 private:
  void extend();
  std::size_t index(const glm::ivec3& i) const { return voxel_index(i, size_); }
  VoxelFrame frame_;
  double band_, reach_;
  glm::ivec3 lo_{0}, size_{0};
  std::vector<float> distance_;
  std::vector<Tissue> tissue_;
  dvec3 low_{0}, high_{0};
};

}  // namespace typodont
