// A whole volume as arrays, sampled anywhere. For pictures, before a session or on request.
#pragma once

#include <array>
#include <vector>

#include "engine/contract/field_brick.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class ToothField {
 public:
  /// Outside the tissue, distances up to `reach` (m) beyond the band are added, within a few percent.
  explicit ToothField(const haptics::TissueVolume& volume, double reach = 0);

  /// m, W: box of the surface and all stored distances.
  const dvec3& low() const { return low_; }
  const dvec3& high() const { return high_; }
  double voxel() const { return frame_.voxel; }

  /// m, negative inside, linear; the largest computed one if no surface is near.
  double distance(const dvec3& p_W) const;
  Tissue tissue(const dvec3& p_W) const;
  /// Just below the nearest surface point.
  Tissue tissue_at_surface(const dvec3& p_W) const;
  /// 0..1 by tissue: labels weighted by a cubic B-spline.
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
