// A whole volume as plain arrays that can be sampled at any point. Used for pictures; built at set-up or when a view is
// requested.
#pragma once

#include <array>
#include <vector>

#include "engine/contract/field_brick.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class ToothField {
 public:
  /// Copies the volume. `reach`: m, distance beyond the band up to which distances outside the tissue are also
  /// available (accurate to a few percent).
  explicit ToothField(const haptics::TissueVolume& volume, double reach = 0);

  /// Bounds of the surface, m, W; they include the band around it.
  const dvec3& low() const { return low_; }
  const dvec3& high() const { return high_; }
  double voxel() const { return frame_.voxel; }

  /// Distance at p, m, negative inside. Interpolated linearly between samples; band + reach if no surface is near.
  double distance(const dvec3& p_W) const;
  Tissue tissue(const dvec3& p_W) const;
  /// Tissue slightly below the surface point nearest to p.
  Tissue tissue_at_surface(const dvec3& p_W) const;
  /// Fraction of each tissue around p, 0..1: neighbouring labels weighted by a cubic B-spline.
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
