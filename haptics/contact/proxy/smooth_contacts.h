// Contacts of the parts of a tool that never cut. The shank's contacts are computed in the coarse patch. At uncut
// tissue they are exact; at cut tissue, the shank has contacts only where it is wider than the head by more than the
// patch resolves. The safe end's contacts are computed in the same patch as the head's.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "haptics/contact/proxy/contact_planes.h"

namespace typodont::haptics {

/// Size of the coarse patch: one sample every `every` voxels, `edge` samples per edge. 0, 0: no coarse patch.
struct CoarseGrid {
  int every = 0, edge = 0;
};
CoarseGrid coarse_grid_for(std::span<const Tool> tools, double voxel, double travel);

/// The non-cutting parts of one tool. Far from tissue, a search costs one comparison for the shank, because the
/// distance that the shank may still move is known from the last search. All lengths in voxels. Never allocates after
/// construction.
class NonCuttingContacts {
 public:
  NonCuttingContacts(const Tool& tool, double voxel);

  bool any() const { return shank_.has_value() || safe_end_.has_value(); }
  /// Distance in voxels that the tool's points may move from X_VT before the shank can touch tissue. Valid only if it
  /// is positive.
  double room(const SurfacePatch& patch, const Pose& X_VT) noexcept;
  /// Adds the contacts of shank and safe end with gaps below `near` to the head's contacts. They allow no slack.
  void find(const SurfacePatch& patch, const Pose& X_VT, double near, ContactSet& set) noexcept;
  /// Adds the contacts of the last find(), updated for a tool that has moved a little.
  void relinearize(const Pose& X_VT, ContactSet& set) noexcept;
  /// Must be called when tissue may have been added: the known free distance is then no longer valid.
  void forget() noexcept { known_ = false; }

 private:
  struct Part {
    Part(const NonCuttingPart& part, double voxel, double patch_voxel);
    ContactFinder finder;  // finder in voxels of the patch in which this part's contacts are computed
    double radius_at(double u) const {
      return std::min(radius, neck + (radius - neck) / taper * u);
    }  // u: distance from the part's lower end
    double z, half, neck, radius, taper;
  };
  struct Known {
    ContactPlane plane;  // in voxels of the part's patch
    bool shank;
    double let;  // overlap that is tolerated, in voxels of the part's patch
  };
  static constexpr int kMost = 5, kRoom = 8;  // limits of the number of contacts: of one part, and of all parts

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
