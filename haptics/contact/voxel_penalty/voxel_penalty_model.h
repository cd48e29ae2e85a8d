// The servo's part of "voxel_penalty": no proxy, but springs on samples of the head (README.md).
#pragma once

#include <vector>

#include "haptics/contact/patch_model.h"
#include "haptics/contact/voxel_penalty/voxel_penalty_method.h"

namespace typodont::haptics::voxel_penalty {

/// Lengths in voxels unless another unit is given. A voxel is full if its centre is inside tissue.
class VoxelPenaltyModel final : public PatchModel {
 public:
  /// Throws Error if a tool is a filling instrument.
  VoxelPenaltyModel(const ServoSettings& settings, const Parameters& parameters);

  double clearance(const Pose& X_WG) noexcept override;
  bool is_free(std::uint32_t tool, const Pose& X_WG) noexcept override;
  void take_up(std::uint32_t tool) noexcept override { tool_ = tool; }
  void constrain(const ContactInput& in, Contact& out) noexcept override;
  bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept override;
  void feel(const ContactInput& in, Contact& contact, Felt& out) noexcept override;

 private:
  struct Head {
    Tool tool;
    std::vector<HeadSample> samples;  // points on the head, frame T, voxels
    double reach;
    // factor for all springs, with which the whole head has the scene's stiffness
    double spring_scale = 1;
  };
  struct Touching {
    dvec3 x, n;       // voxels: position; unit vector: outward normal of the head
    double depth;     // voxels, depth of the sample inside full voxels
    double area;      // m², area of the head that the sample represents
    Tissue tissue;    // tissue of the voxel that contains the sample
    double hardness;  // 0..1, hardness of the voxel that contains the sample
  };

  const Head& head() const noexcept { return heads_[tool_]; }
  void probe(const Head& head, const Pose& X_VT) noexcept;
  bool is_full(const glm::ivec3& voxel) const noexcept;
  double depth_along(const dvec3& x, const dvec3& direction, double most) const noexcept;
  void sum_springs(const ContactInput& in, Contact& out) const noexcept;

  PerTissue repeat(const CutLog::Made& made, std::uint64_t index, TissuePatch& fresh) noexcept override;
  void adopted(bool, bool) noexcept override {}

  Parameters parameters_;
  std::vector<Head> heads_;
  std::uint32_t tool_ = 0;
  std::vector<Touching> touching_;  // allocated at set-up
  std::size_t count_ = 0;
  dvec3 c_{0};  // voxels, the head's centre in this tick, frame V
};

}  // namespace typodont::haptics::voxel_penalty
