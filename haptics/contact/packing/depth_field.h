// Computes the depth of a point in its own tissue from a field of distances and labels. Set-up time.
#pragma once

#include <cstddef>
#include <vector>

#include "haptics/tissue_volume.h"

namespace typodont::haptics::packing {

/// Depth of a point in tissue: its distance to the tissue's surface or to the border with another tissue, whichever
/// is nearer. Lengths and positions are in voxels of the field; p_V = (0,0,0) is the first sample.
class DepthField {
 public:
  explicit DepthField(const DenseTissue& tissue);

  const VoxelFrame& frame() const { return frame_; }
  const glm::ivec3& size() const { return size_; }
  /// Volume per tissue, m³. Each voxel counts with the fraction of it that lies inside the surface.
  const PerTissue& volume() const { return volume_; }

  /// The tissue of the nearest sample that has one; kAir if none of the eight samples around the point has one.
  Tissue tissue_at(const dvec3& p_V) const;
  /// Depth in the tissue at p; -1 if p is not in tissue.
  double at(const dvec3& p_V) const { return in(tissue_at(p_V), p_V); }
  /// Depth in the given tissue, trilinear; negative outside this tissue. -1 for kAir, and outside the samples.
  double in(Tissue tissue, const dvec3& p_V) const;

 private:
  // The arrays have one additional sample of air on every side, so that every voxel has 26 neighbours.
  std::size_t index(const glm::ivec3& v) const {
    return static_cast<std::size_t>((v.x + 1) * stride_x_ + (v.y + 1) * stride_y_ + v.z + 1);
  }
  void copy(const DenseTissue& tissue);
  void smooth_labels();
  void find_closest_points(double band);

  VoxelFrame frame_;
  glm::ivec3 size_;
  std::ptrdiff_t stride_x_ = 0, stride_y_ = 0;
  std::vector<float> depth_;           // voxels, depth in the tissue; outside tissue the negative distance to tissue
  std::vector<Tissue> label_;          // kAir outside the tissue
  std::vector<std::ptrdiff_t> solid_;  // indices of the voxels in tissue, in the order of the arrays
  PerTissue volume_{};
};

}  // namespace typodont::haptics::packing
