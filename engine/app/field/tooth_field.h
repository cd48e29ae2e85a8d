// A whole volume as plain arrays, to be sampled anywhere: for pictures of it, made at set-up or when a view is asked
// for.
#pragma once

#include <array>
#include <vector>

#include "engine/contract/field_brick.h"
#include "haptics/tissue_volume.h"

namespace typodont {

class ToothField {
 public:
  /// `reach`: m beyond the band in which distances outside are known too (within some percent).
  explicit ToothField(const haptics::TissueVolume& volume, double reach = 0);

  /// m, W: of the surface, with the band around it.
  const dvec3& low() const { return low_; }
  const dvec3& high() const { return high_; }
  double voxel() const { return frame_.voxel; }

  /// m, negative inside. Linear between samples; band + reach where nothing is near.
  double distance(const dvec3& p_W) const;
  Tissue tissue(const dvec3& p_W) const;
  /// Of the surface's point nearest to p, a little beneath it.
  Tissue tissue_at_surface(const dvec3& p_W) const;
  /// How much of the tissue about p is of each kind, 0..1: labels of the samples around, by cubic B-spline weights.
  std::array<double, kTissueCount> shares(const dvec3& p_W) const;

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
