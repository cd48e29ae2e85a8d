// Contacts of what of a tool never cuts: its shank, felt in the wide patch (flat tissue and edges that nobody cut as
// they are, what was cut only where the shank is wider than the head by more than that field tells), and its safe end,
// felt beside the head.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "haptics/contact/proxy/contact_planes.h"

namespace typodont::haptics {

/// Of the wide patch that shanks are felt in: every so many voxels one sample, so many samples an edge; none: 0, 0.
struct WideGrid {
  int every = 0, edge = 0;
};
WideGrid wide_grid_for(std::span<const Tool> tools, double voxel, double travel);

/// One tool's. Far from tissue the shank costs one comparison a look: how far it may still move is known from the last
/// time it was looked at. All lengths in voxels. Never allocates after construction.
class SmoothContacts {
 public:
  SmoothContacts(const Tool& tool, double voxel);

  bool any() const { return shank_.has_value() || safe_end_.has_value(); }
  /// How far the tool may move or turn from X_VT before its shank can touch; right as far as it is positive.
  double room(const SurfacePatch& patch, const Pose& X_VT) noexcept;
  /// Adds what shank and safe end touch, with gaps below `near`, to the head's contacts; what does not yield holds.
  void find(const SurfacePatch& patch, const Pose& X_VT, double near, ContactSet& set) noexcept;
  /// The same contacts seen from a tool that has moved a little.
  void relinearize(const Pose& X_VT, ContactSet& set) noexcept;
  /// The tissue may have come closer.
  void forget() noexcept { known_ = false; }

 private:
  struct Part {
    Part(const SmoothPart& part, double voxel, double patch_voxel);
    ContactFinder finder;  // in voxels of the patch that it is felt in
    double radius_at(double u) const {
      return std::min(radius, neck + (radius - neck) / taper * u);
    }  // u from its lower end
    double z, half, neck, radius, taper;
  };
  struct Known {
    ContactPlane plane;  // in voxels of that patch
    bool shank;
    double let;  // overlap that does not count, in the same
  };
  static constexpr int kMost = 5, kRoom = 8;  // of one part; of all

  void look(const Part& part, const SurfacePatch& patch, const Pose& X, double near, bool shank) noexcept;
  double let_by(double radius, const SurfacePatch& patch, const dvec3& x) const noexcept;
  double let_by(const Part& part, const SurfacePatch& patch, const Pose& X, const ContactPlane& plane) const noexcept;
  void look_from_axis(const Part& part, const SurfacePatch& patch, const Pose& X, double near) noexcept;
  void hand_over(ContactSet& set) const noexcept;
  Pose in_part(const Part& part, const Pose& X_VT, int every) const noexcept;

  std::optional<Part> shank_, safe_end_;
  int every_ = 1;
  double head_ = 0;  // radius of the head, voxels
  ContactSet set_;
  std::array<Known, kRoom> contacts_;
  int count_ = 0;
  bool known_ = false;
  double free_ = 0;
  Pose at_;
};

}  // namespace typodont::haptics
