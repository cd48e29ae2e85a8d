// Labels and grey values of a jaw at any point, and its nerve canals. Any thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <utility>
#include <vector>

#include "engine/app/tissue/bone_tissue.h"
#include "engine/base/voxels.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// All positions in m, frame W.
class PlanningTissue {
 public:
  /// Copies labels and hardness; of a volume with more than kMaxSamples voxels, only every n-th along each axis.
  explicit PlanningTissue(const haptics::TissueVolume& volume);

  static constexpr double kMaxSamples = 1e8;

  /// Tissue of the nearest sample; kAir outside of the volume.
  Tissue at(const dvec3& p_W) const;
  /// Grey value, Hounsfield units: the tissue's grey value multiplied by the hardness; −1000 in air.
  double grey(const dvec3& p_W) const;
  bool is_bone(const dvec3& p_W) const;
  bool is_tooth(const dvec3& p_W) const;

  double spacing() const { return frame_.voxel; }  // the distance (m) between two neighbouring samples
  dvec3 lo_W() const { return frame_.to_world(dvec3(0)); }
  dvec3 hi_W() const { return frame_.to_world(dvec3(size_ - 1)); }

  /// Nerve canals: connected nerve tissue in bone, at least 8 mm long, as centre points at most 2 mm apart.
  std::vector<NerveCanal> canals() const;

 private:
  /// Index of the nearest sample; outside the box: number of samples.
  std::size_t index(const dvec3& p_W) const;
  std::size_t index(const glm::ivec3& p) const { return voxel_index(p, size_); }
  bool inside(const glm::ivec3& p) const { return in_grid(p, size_); }
  /// Path lengths from `from` within one tissue, in samples, ascending.
  std::vector<std::pair<glm::ivec3, int>> distances_within_piece(const glm::ivec3& from) const;

  VoxelFrame frame_;
  glm::ivec3 size_{0};
  std::vector<Tissue> tissue_;
  std::vector<std::uint8_t> hardness_;
  BoneGrey bone_grey_;
};

}  // namespace typodont
