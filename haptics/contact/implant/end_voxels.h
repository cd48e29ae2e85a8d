// The tool voxels on the front of a tool's end, and the sums of the cutting law over them for one pose of the tool.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/contact.h"
#include "haptics/contact/implant/tool_voxels.h"
#include "haptics/surface_patch.h"

namespace typodont::haptics::implant {

/// The tool voxels on the front of the tool's end, which is the side that moves into the bone. These voxels are the
/// first ToolVoxels::ahead elements of ToolVoxels::outer. This struct stores one array per property. Padding voxels,
/// which never touch bone, fill the last block.
struct EndVoxels {
  static constexpr std::size_t kBlock = 32;  // number of tool voxels that are evaluated together

  /// Copies all tool voxels on the front of the tool's end (the side that moves into the bone), in their original
  /// order.
  explicit EndVoxels(const ToolVoxels& voxels) : EndVoxels(voxels, 0) {}
  /// On flat parts of the end, merges each square of four voxels into one voxel if the edge of the merged voxel is at
  /// most `coarsest` (m). The field is linear within a voxel of the tissue, so a finer sampling would not improve the
  /// result.
  EndVoxels(const ToolVoxels& voxels, double coarsest);

  std::vector<float> x, y, z;  // m, positions of the voxels in the tool's frame T
  std::vector<float> outside;  // m, signed distance from the head's surface (ToolVoxel::outside)
  std::vector<float> area;     // m², area of the tool's surface that the voxel represents
  // cosine of the angle between the head's outward normal at the voxel and the feed direction -z
  std::vector<float> facing;
  std::vector<float> inverse_r;                 // 1/m, mean of 1/r over the voxel (ToolVoxel::inverse_r)
  std::vector<float> ability, inverse_ability;  // ability to drill, 0..1, and its reciprocal (0 for ability 0)
  std::vector<float> r;                         // m, distance of each voxel from the tool's axis
  std::size_t count = 0;                        // number of stored voxels, without the padding voxels
  // the area of the whole end divided by the area of the stored voxels: 1 / ToolVoxels::ahead_fraction
  double fraction = 1;
};

/// Properties of the tissues and the tool for look_at_end(). SI units.
struct EndLaw {
  double voxel = 0;  // m, voxel size of the patch (copy of the field around the tool)
  // m; a tool voxel that cannot cut stops the tool only if its distance from the tool's axis is below this radius
  double width = 0;
  bool cuts = false;         // true if tool voxels can cut; false for example if the spindle is stopped
  double greatest_grey = 0;  // Hounsfield units, largest grey value of bone that the tool can cut
  double speed = 0;          // rad/s, speed of the spindle
  double thrust_ratio = 1;
  PerTissue energy{};  // J/m³, specific cutting energy at hardness 1
  // The grey value of a tissue in Hounsfield units is grey + grey_per_hardness · hardness.
  PerTissue grey{}, grey_per_hardness{};
};

/// Result of look_at_end().
struct EndLook {
  CuttingWrench wrench;  // force and torque on the tool, in the tool's frame T, divided by the feed speed along -z
  double free = 1e9;     // m, distance that the tool may advance before a voxel that cannot cut touches bone
  double engaged = 0;    // m², area of the tool's end that is in contact with bone
  // m², part of the area `engaged` where an obstacle blocks the advance; called num_cd in Zhao 2020
  double collided = 0;
  double greatest_grey = 0;  // Hounsfield units, greatest grey value of the bone in contact
  PerTissue tissue{};    // m², for each tissue: the part of `engaged` (contact area of the tool's end) that touches it
  PerTissue hardness{};  // m², for each tissue: the area that touches it, multiplied by the tissue's hardness
};

/// Adds the forces of the cutting law over the tool voxels on the front of the tool's end, and looks for obstacles
/// ahead of them. `center_V`: centre of the head, in voxels; `R_WT`: orientation of the tool. The patch (copy of the
/// field) must contain all samples up to two voxels beyond the end. Each tool voxel has a weight in the sums: 1 if bone
/// touches it, falling linearly to 0 if the bone is one patch voxel away, so that forces change continuously. All
/// processors give the same bits, because the sums have a fixed order.
EndLook look_at_end(const EndVoxels& voxels, const SurfacePatch& patch, const EndLaw& law, const dvec3& center_V,
                    const dquat& R_WT) noexcept;

}  // namespace typodont::haptics::implant
