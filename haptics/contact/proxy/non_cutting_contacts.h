// Contacts of the parts of a tool that never cut. The contacts of the shank are computed in the coarse patch (field
// around the shank). At uncut tissue they are exact. At cut tissue, the shank has contacts only where it is clearly
// wider than the head, because the coarse patch cannot resolve small differences. The contacts of the safe end (a pin
// at the tip) are computed in the same patch as those of the head.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "haptics/contact/proxy/contact_planes.h"

namespace typodont::haptics {

/// Size of the coarse patch. The coarse patch contains one of every `every` samples along each axis, and has `edge`
/// samples along each axis. If both values are 0, there is no coarse patch.
struct CoarseGrid {
  int every = 0, edge = 0;
};
CoarseGrid coarse_grid_for(std::span<const Tool> tools, double voxel, double travel);

/// The non-cutting parts of one tool. Far from tissue, a search for contacts of the shank needs only one comparison,
/// because the free distance is known from an earlier search. All lengths in voxels. Never allocates after
/// construction.
class NonCuttingContacts {
 public:
  NonCuttingContacts(const Tool& tool, double voxel);

  bool any() const { return shank_.has_value() || safe_end_.has_value(); }
  /// Returns the distance in voxels that the tool may move from the pose X_VT before the shank can touch tissue. Valid
  /// only if it is positive.
  double room(const SurfacePatch& patch, const Pose& X_VT) noexcept;
  /// Finds the contacts of the shank and the safe end (pin at the tip) whose gaps are below `near` (voxels), and adds
  /// them to `set`, which contains the head's contacts. Shank and safe end may not sink into the tissue.
  void find(const SurfacePatch& patch, const Pose& X_VT, double near, ContactSet& set) noexcept;
  /// Adds the contacts of the last find() to `set` again, updated for a small motion of the tool to the pose X_VT.
  void relinearize(const Pose& X_VT, ContactSet& set) noexcept;
  /// Must be called when tissue may have been added, because the stored free distance is then not valid any more.
  void forget() noexcept { known_ = false; }

 private:
  struct Part {
    Part(const NonCuttingPart& part, double voxel, double patch_voxel);
    ContactFinder finder;  // contact finder of this part; its lengths are in voxels of the patch that it searches
    double radius_at(double u) const {
      return std::min(radius, neck + (radius - neck) / taper * u);
    }  // returns the radius of the part at the distance `u` along the axis from its lower end
    double z, half, neck, radius, taper;
  };
  struct Known {
    ContactPlane plane;  // contact plane, in voxels of the patch of this part (shank or safe end)
    bool shank;
    double let;  // allowed overlap of tissue and part (shank or safe end), in voxels of the patch of this part
  };
  static constexpr int kMost = 5, kRoom = 8;  // kMost: largest number of contacts of one part; kRoom: of all parts

  void look(const Part& part, const SurfacePatch& patch, const Pose& X, double near, bool shank) noexcept;
  double tolerated_overlap(double radius, const SurfacePatch& patch, const dvec3& x) const noexcept;
  double tolerated_overlap(const Part& part, const SurfacePatch& patch, const Pose& X,
                           const ContactPlane& plane) const noexcept;
  void search_from_axis(const Part& part, const SurfacePatch& patch, const Pose& X, double near) noexcept;
  void append_to(ContactSet& set) const noexcept;
  Pose in_part(const Part& part, const Pose& X_VT, int every) const noexcept;

  std::optional<Part> shank_, safe_end_;
  int every_ = 1;
  double head_ = 0;  // voxels, radius of the head
  ContactSet set_;
  std::array<Known, kRoom> contacts_;
  int count_ = 0;
  bool known_ = false;
  double free_ = 0;
  Pose at_;
};

}  // namespace typodont::haptics
