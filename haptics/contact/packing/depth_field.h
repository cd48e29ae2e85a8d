// Depth of points inside a tissue. Set-up only.
#pragma once

#include <cstddef>
#include <vector>

#include "haptics/tissue_volume.h"

namespace typodont::haptics::packing {

/// Distance of a point to the nearest surface or border with another tissue, in voxels. p_V = (0,0,0) is the position
/// of the field's first sample.
class DepthField {
 public:
  explicit DepthField(const DenseTissue& tissue);

  const VoxelFrame& frame() const { return frame_; }
  const glm::ivec3& size() const { return size_; }
  /// m³, volume of each tissue: sum of its fractions in all voxels.
  const PerTissue& volume() const { return volume_; }

  /// Tissue of the nearest of the eight samples around p_V that contains tissue; kAir: none.
  Tissue tissue_at(const dvec3& p_V) const;
  /// Depth of p_V below the border of the tissue at p_V, voxels; -1: no tissue.
  double at(const dvec3& p_V) const { return in(tissue_at(p_V), p_V); }
  /// Depth of p_V in `tissue`, voxels (trilinear). Negative outside this tissue; -1 outside the field and for kAir.
  double in(Tissue tissue, const dvec3& p_V) const;

 private:
  // The arrays have an additional layer of air, so that every voxel has 26 neighbours.
  std::size_t index(const glm::ivec3& v) const {
    return static_cast<std::size_t>((v.x + 1) * stride_x_ + (v.y + 1) * stride_y_ + v.z + 1);
  }
  void copy(const DenseTissue& tissue);
  void smooth_labels();
  void find_closest_points(double band);

  VoxelFrame frame_;
  glm::ivec3 size_;
  std::ptrdiff_t stride_x_ = 0, stride_y_ = 0;
  std::vector<float> depth_;           // voxels, depth; in air, minus the distance to tissue
  std::vector<Tissue> label_;          // label of each voxel; kAir outside the tissue
  std::vector<std::ptrdiff_t> solid_;  // indices of the voxels with tissue, ascending
  PerTissue volume_{};
};

}  // namespace typodont::haptics::packing
