// A copy of a jaw's tissue as arrays of samples, for planning. Provides labels and grey values at any point, and the
// nerve canals. After its construction, it may be used by any thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <utility>
#include <vector>

#include "engine/app/tissue/bone_tissue.h"
#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// The tissue of a jaw. All points are in m, frame W.
class PlanningTissue {
 public:
  /// Copies the tissue labels and the hardness of the whole volume. At most kMostSamples samples are stored. From a
  /// larger volume, only every n-th voxel along each axis is copied.
  explicit PlanningTissue(const haptics::TissueVolume& volume);

  static constexpr double kMostSamples = 1e8;

  /// Returns the tissue of the sample that is nearest to the position; kAir outside the tissue.
  Tissue at(const dvec3& p_W) const;
  /// Returns the grey value (Hounsfield units) of the sample that is nearest to the position. In tissue, this is the
  /// grey value of the kind of tissue times the hardness of the sample; in air, it is −1000.
  double grey(const dvec3& p_W) const;
  bool is_bone(const dvec3& p_W) const;
  bool is_tooth(const dvec3& p_W) const;

  double spacing() const { return frame_.voxel; }  // returns the distance (m) between two neighbouring samples
  dvec3 lo_W() const { return frame_.to_world(dvec3(0)); }
  dvec3 hi_W() const { return frame_.to_world(dvec3(size_ - 1)); }

  /// Returns the nerve canals as polylines. A canal is a connected piece of nerve tissue that lies in bone (not in a
  /// tooth) and is at least 8 mm long. Its points are the centres of sections that are at most 2 mm apart.
  std::vector<NerveCanal> canals() const;

 private:
  /// Returns the index of the sample that is nearest to the position. For a position outside the tissue's box, returns
  /// the number of samples.
  std::size_t index(const dvec3& p_W) const;
  std::size_t index(const glm::ivec3& p) const {
    return (static_cast<std::size_t>(p.x) * static_cast<std::size_t>(size_.y) + static_cast<std::size_t>(p.y)) *
               static_cast<std::size_t>(size_.z) +
           static_cast<std::size_t>(p.z);
  }
  bool inside(const glm::ivec3& p) const {
    return glm::all(glm::greaterThanEqual(p, glm::ivec3(0))) && glm::all(glm::lessThan(p, size_));
  }
  /// Computes the lengths of the paths inside a connected piece of one tissue, from the sample `from` to every other
  /// sample of this piece. A length is a number of samples. The list is sorted by length, so the farthest sample is the
  /// last.
  std::vector<std::pair<glm::ivec3, int>> distances_within_piece(const glm::ivec3& from) const;

  VoxelFrame frame_;
  glm::ivec3 size_{0};
  std::vector<Tissue> tissue_;
  std::vector<std::uint8_t> hardness_;
  BoneGrey bone_grey_;
};

}  // namespace typodont
