// Voxels of a tool's end, and the cutting law over them.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/contact.h"
#include "haptics/contact/implant/tool_voxels.h"
#include "haptics/contact/surface_patch.h"

namespace typodont::haptics::implant {

/// First ToolVoxels::ahead of ToolVoxels::outer, which move into the bone, as arrays; padding, never in contact, fills
/// the last block.
struct EndVoxels {
  static constexpr std::size_t kBlock = 32;  // number of tool voxels that are evaluated together

  /// All, in their order.
  explicit EndVoxels(const ToolVoxels& voxels) : EndVoxels(voxels, 0) {}
  /// Four become one where flat, up to an edge of `coarsest` (m): the field is linear in a voxel, finer gains nothing.
  EndVoxels(const ToolVoxels& voxels, double coarsest);

  std::vector<float> x, y, z;  // m, T
  std::vector<float> outside;  // m, signed distance from the head's surface (ToolVoxel::outside)
  std::vector<float> area;     // m² of the tool's surface
  // cosine of outward normal and feed -z
  std::vector<float> facing;
  std::vector<float> inverse_r;                 // 1/m, mean of 1/r over the voxel (ToolVoxel::inverse_r)
  std::vector<float> ability, inverse_ability;  // 0..1, and 1 / it (0 for 0)
  std::vector<float> r;                         // m from the axis
  std::size_t count = 0;                        // number of stored voxels, without the padding voxels
  // whole end / stored area: 1 / ToolVoxels::ahead_fraction
  double fraction = 1;
};

/// SI.
struct EndLaw {
  double voxel = 0;  // m, of the patch
  // m from the axis, within which a voxel that cannot cut stops the tool
  double width = 0;
  bool cuts = false;         // false, for example, at rest
  double greatest_grey = 0;  // Hounsfield units that can be cut
  double speed = 0;          // rad/s, speed of the spindle
  double thrust_ratio = 1;
  PerTissue energy{};  // J/m³, specific cutting energy at hardness 1
  // Hounsfield units: grey + grey_per_hardness · hardness.
  PerTissue grey{}, grey_per_hardness{};
};

/// Result of look_at_end().
struct EndLook {
  CuttingWrench wrench;  // on the tool, T, / feed speed along -z
  double free = 1e9;     // m until what cannot cut touches bone
  double engaged = 0;    // m² of the end in contact
  // m² of these, blocked: num_cd of Zhao 2020
  double collided = 0;
  double greatest_grey = 0;  // Hounsfield units, greatest in contact
  PerTissue tissue{};        // m² of `engaged`, per tissue
  PerTissue hardness{};      // m² × hardness, per tissue
};

/// Cutting law, and obstacles ahead. `center_V`: voxels. The patch must reach two voxels beyond. Weights fall from 1 at
/// bone to 0 a voxel away, so forces are continuous. Fixed order: same bits everywhere.
EndLook look_at_end(const EndVoxels& voxels, const SurfacePatch& patch, const EndLaw& law, const dvec3& center_V,
                    const dquat& R_WT) noexcept;

}  // namespace typodont::haptics::implant
