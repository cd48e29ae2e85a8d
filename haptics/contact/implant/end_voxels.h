// The voxels in front of a tool's end, and the cutting law summed over all of them at one pose.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/contact.h"
#include "haptics/contact/implant/tool_voxels.h"
#include "haptics/surface_patch.h"

namespace typodont::haptics::implant {

/// The voxels in front of the end (the first ToolVoxels::ahead of ToolVoxels::outer) with one array per property. The
/// arrays are padded to whole blocks with voxels that never touch bone.
struct EndVoxels {
  static constexpr std::size_t kBlock = 32;  // voxels that are evaluated together

  /// All voxels, in the same order.
  explicit EndVoxels(const ToolVoxels& voxels) : EndVoxels(voxels, 0) {}
  /// On a flat part of the end, each square of four voxels becomes one voxel, if its edge is at most `coarsest` (m):
  /// the field is linear within a voxel of the tissue, so a finer sampling adds nothing.
  EndVoxels(const ToolVoxels& voxels, double coarsest);

  std::vector<float> x, y, z;                   // m, in T
  std::vector<float> outside;                   // m, see ToolVoxel
  std::vector<float> area;                      // m²
  std::vector<float> facing;                    // cosine between the outward normal and the feed along -z
  std::vector<float> inverse_r;                 // 1/m
  std::vector<float> ability, inverse_ability;  // inverse_ability is 0 where ability is 0
  std::vector<float> r;                         // m, distance from the axis
  std::size_t count = 0;                        // voxels without the padding
  double share = 1;                             // factor of the areas: 1 / ToolVoxels::ahead_share
};

/// Properties of tissues and tool for look_at_end(). SI.
struct EndLaw {
  std::uint32_t laws = kServoLaws;  // version of the force laws (contract/contact.h); before 6 with other rounding
  double voxel = 0;                 // m, voxel of the patch
  double width = 0;                 // m, a voxel that cannot cut stops the tool only within this distance from the axis
  bool cuts = false;                // false: no voxel cuts
  double greatest_grey = 0;         // Hounsfield units, greatest grey value that the tool cuts
  double speed = 0;                 // rad/s, speed of the spindle
  double thrust_ratio = 1;
  PerTissue energy{};  // J/m³, specific cutting energy at hardness 1
  // Hounsfield units: the grey value of a tissue is grey + grey_per_hardness · hardness.
  PerTissue grey{}, grey_per_hardness{};
};

/// Result of look_at_end().
struct EndLook {
  CuttingWrench wrench;      // force and torque in T, per m/s of feed along -z
  double free = 1e9;         // m, distance that the tool may advance before a non-cutting voxel touches bone
  double engaged = 0;        // m², area of the end in contact with bone
  double collided = 0;       // m², part of `engaged` at which an obstacle blocks the advance; num_cd in the paper
  double greatest_grey = 0;  // Hounsfield units, greatest grey value of the bone in contact
  PerTissue tissue{};        // m², part of `engaged` per tissue
  PerTissue hardness{};      // m², area of each part in `tissue`, multiplied by its hardness
};

/// Evaluates the cutting law and the obstacles over the voxels in front of the end. `center_V`: the head's centre in
/// voxels; `R_WT`: the tool's orientation. The patch must hold all samples up to two voxels beyond the end. A voxel is
/// weighted by the bone's distance from the tool's surface: fully at contact, zero from one patch voxel of distance. So
/// forces change without steps. All processors compute the same bits, and sums run in the order of the voxels.
EndLook look_at_end(const EndVoxels& voxels, const SurfacePatch& patch, const EndLaw& law, const dvec3& center_V,
                    const dquat& R_WT) noexcept;

}  // namespace typodont::haptics::implant
