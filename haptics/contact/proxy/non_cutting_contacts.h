// Contacts of the parts of a tool that never cut. Contacts of the shank are searched in the coarse tissue patch; near
// cuts, only where the shank is clearly wider than the head. The safe end (pin at the tip) uses the head's patch.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "haptics/contact/proxy/contact_planes.h"

namespace typodont::haptics {

/// Size of the coarse tissue patch: every `every`-th sample along each axis, `edge` samples per axis. 0: no coarse
/// patch.
struct CoarseGrid {
  int every = 0, edge = 0;
};
CoarseGrid coarse_grid_for(std::span<const Tool> tools, double voxel, double travel);

/// The non-cutting parts (shank and safe end) of one tool. Far from tissue, a search also gives the
/// distance by which the tool may move before a new search. Lengths in voxels. Never allocates after construction.
class NonCuttingContacts {
 public:
  NonCuttingContacts(const Tool& tool, double voxel);

  bool any() const { return shank_.has_value() || safe_end_.has_value(); }
  /// Distance in voxels that the tool may move from the pose X_VT before the shank can touch tissue. Valid only if it
  /// is positive.
  double clearance(const TissuePatch& patch, const Pose& X_VT) noexcept;
  /// Finds the contacts of the shank and the safe end (pin at the tip) whose gaps are below `near` (voxels), and adds
  /// them to `set`, which contains the head's contacts. Shank and safe end may not sink into the tissue.
  void find(const TissuePatch& patch, const Pose& X_VT, double near, ContactSet& set) noexcept;
  /// Adds the contacts of the last find() to `set` again, updated for a small motion of the tool to the pose X_VT.
  void relinearize(const Pose& X_VT, ContactSet& set) noexcept;
  /// Must be called when tissue may have been added, because the stored free distance is then not valid any more.
  void forget() noexcept { known_ = false; }

 private:
  struct Part {
    Part(const NonCuttingPart& part, double voxel, double patch_voxel);
    ContactFinder finder;  // lengths in voxels of the tissue patch that is used for this part
    double radius_at(double u) const {
      return std::min(radius, neck + (radius - neck) / taper * u);
    }  // radius of the part at the distance `u` along the axis from its lower end
    double z, half, neck, radius, taper;
  };
  struct Known {
    ContactPlane plane;  // contact, in voxels of the tissue patch that the tool's part uses
    bool shank;
    double let;  // allowed overlap of tissue and part, in voxels of the same tissue patch as `plane`
  };
  static constexpr int kMost = 5, kCapacity = 8;  // largest numbers of contacts: of one part; of all parts

  void search(const Part& part, const TissuePatch& patch, const Pose& X, double near, bool shank) noexcept;
  double tolerated_overlap(double radius, const TissuePatch& patch, const dvec3& x) const noexcept;
  double tolerated_overlap(const Part& part, const TissuePatch& patch, const Pose& X,
                           const ContactPlane& plane) const noexcept;
  void search_from_axis(const Part& part, const TissuePatch& patch, const Pose& X, double near) noexcept;
  void append_to(ContactSet& set) const noexcept;
  Pose in_part(const Part& part, const Pose& X_VT, int every) const noexcept;

  std::optional<Part> shank_, safe_end_;
  int every_ = 1;
  double head_ = 0;  // voxels, radius of the head
  ContactSet set_;
  std::array<Known, kCapacity> contacts_;
  int count_ = 0;
  bool known_ = false;
  double free_ = 0;
  Pose at_;
};

}  // namespace typodont::haptics
