// Computes the depth of a point inside its tissue, from a field of distances and labels. Called only during set-up.
#pragma once

#include <cstddef>
#include <vector>

#include "haptics/tissue_volume.h"

namespace typodont::haptics::packing {

/// Depth of a point in tissue: its distance to the nearest surface of the tissue or border with another tissue. Lengths
/// and positions are in voxels of the field; p_V = (0,0,0) is the first sample.
class DepthField {
 public:
  explicit DepthField(const DenseTissue& tissue);

  const VoxelFrame& frame() const { return frame_; }
  const glm::ivec3& size() const { return size_; }
  /// Returns the volume of each tissue in m³. A voxel at the surface counts with the fraction that lies inside.
  const PerTissue& volume() const { return volume_; }

  /// Returns the tissue of the nearest of the eight samples around the point; samples without tissue are skipped.
  /// Returns kAir if none of them has tissue.
  Tissue tissue_at(const dvec3& p_V) const;
  /// Returns the depth (voxels) of the point p in its own tissue; -1 if there is no tissue at p.
  double at(const dvec3& p_V) const { return in(tissue_at(p_V), p_V); }
  /// Returns the depth (voxels) of a point in the given tissue, by trilinear interpolation. The depth is negative
  /// outside this tissue. It is -1 outside the field, and always -1 for the tissue kAir.
  double in(Tissue tissue, const dvec3& p_V) const;

 private:
  // The arrays have an additional layer of air samples on every side, so that every voxel has 26 neighbours.
  std::size_t index(const glm::ivec3& v) const {
    return static_cast<std::size_t>((v.x + 1) * stride_x_ + (v.y + 1) * stride_y_ + v.z + 1);
  }
  void copy(const DenseTissue& tissue);
  void smooth_labels();
  void find_closest_points(double band);

  VoxelFrame frame_;
  glm::ivec3 size_;
  std::ptrdiff_t stride_x_ = 0, stride_y_ = 0;
  std::vector<float> depth_;           // voxels, depth in the tissue; in air, the negative distance to tissue
  std::vector<Tissue> label_;          // label of each voxel; kAir outside the tissue
  std::vector<std::ptrdiff_t> solid_;  // indices of all voxels with tissue, in ascending order
  PerTissue volume_{};
};

}  // namespace typodont::haptics::packing
