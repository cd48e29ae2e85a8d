// The tool voxels at the end of an implant tool, and the force and torque of cutting as a sum over these voxels.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/contact.h"
#include "haptics/contact/implant/tool_voxels.h"
#include "haptics/contact/tissue_patch.h"

namespace typodont::haptics::implant {

/// Arrays with one element per tool voxel: the first ToolVoxels::ahead voxels of ToolVoxels::outer. Padding fills the
/// last block of kBlock voxels; it never has contact.
struct EndVoxels {
  static constexpr std::size_t kBlock = 32;  // number of voxels that are evaluated together

  /// Stores all voxels of the tool's end in their order.
  explicit EndVoxels(const ToolVoxels& voxels) : EndVoxels(voxels, 0) {}
  /// Merges four tool voxels into one where the tool is flat, up to an edge length of `coarsest` (m). The bone's
  /// distance field is linear in a tissue voxel, so finer tool voxels give no better result.
  EndVoxels(const ToolVoxels& voxels, double coarsest);

  std::vector<float> x, y, z;  // m, positions in frame T
  std::vector<float> outside;  // m, signed distance from the head's surface (ToolVoxel::outside)
  std::vector<float> area;     // m², surface area of the tool that the voxel represents
  // cosine between the outward normal and the feed -z
  std::vector<float> facing;
  std::vector<float> inverse_r;                 // 1/m, mean of 1/r over the voxel (ToolVoxel::inverse_r)
  std::vector<float> ability, inverse_ability;  // cutting ability 0..1, and its reciprocal (0 for 0)
  std::vector<float> r;                         // m, distance from the axis
  // voxels (tissue); a tool voxel touches bone only if the distance from bone ahead of it is below this
  std::vector<float> in_bone;
  std::size_t count = 0;  // number of stored voxels, without the padding voxels
};

/// Parameters of the cutting law in this tick. SI.
struct EndLaw {
  double voxel = 0;  // m, voxel size of the tissue patch
  // m; a tool voxel that cannot cut stops the tool only within this distance from the axis
  double width = 0;
  bool cuts = false;    // false: the tool cannot cut, for example at rest
  double max_grey = 0;  // Hounsfield units, densest bone that can be cut
  double speed = 0;     // rad/s, speed of the spindle
  double thrust_ratio = 1;
  PerTissue energy{};  // J/m³, specific cutting energy at hardness 1
  // Hounsfield units; the grey value of a tissue is grey + grey_per_hardness · hardness (0..1).
  PerTissue grey{}, grey_per_hardness{};
};

/// Result of scan_end().
struct EndScan {
  CuttingWrench wrench;  // force and torque per feed speed along -z, frame T
  double free = 1e9;     // m, motion along -z until a voxel that cannot cut touches bone
  double engaged = 0;    // m², area of the end in contact
  // m², area of the tool voxels in contact with bone that they cannot cut (num_cd of Zhao 2020)
  double collided = 0;
  double max_grey = 0;   // Hounsfield units, largest grey value in contact
  PerTissue tissue{};    // m², part of `engaged` in each tissue
  PerTissue hardness{};  // m², for each tissue: sum of contact area × hardness (0..1)
};

/// Sums the cutting law over the tool's end; finds obstacles ahead. `center_V`: head's centre, voxels. A voxel's weight
/// is 1 at bone and 0 one voxel away. The patch must reach two voxels beyond the tool. Bit-identical on all processors.
EndScan scan_end(const EndVoxels& voxels, const TissuePatch& patch, const EndLaw& law, const dvec3& center_V,
                 const dquat& R_WT) noexcept;

}  // namespace typodont::haptics::implant
