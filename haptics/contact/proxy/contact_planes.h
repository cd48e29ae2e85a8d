// The search for contacts between head and tissue.
#pragma once

#include <memory>

#include "haptics/contact/proxy/contact_set.h"
#include "haptics/surface_patch.h"
#include "haptics/tool.h"

namespace typodont::haptics {

struct HeadSamples;

/// Finds the contacts of one head. Built at set-up; the other functions are servo-safe.
class ContactFinder {
 public:
  ContactFinder(const Tool& tool, double voxel);
  ~ContactFinder();
  ContactFinder(ContactFinder&&) noexcept;
  ContactFinder& operator=(ContactFinder&&) noexcept;

  double reach() const { return reach_; }  // voxels, farthest point of the head

  /// Finds the contacts of the head at X_VT (translation in voxels) whose gap is below `near` (voxels, at most about
  /// one). Each surface sample of the head near tissue gives one contact; where the offset surface is smooth, there
  /// is a single exact contact. The patch must contain the head.
  void find(const SurfacePatch& patch, const Pose& X_VT, double near, ContactSet& set) const noexcept;

  /// Computes where a ball that is pulled from `c` to `target` (voxels) comes to rest if one smooth wall holds it.
  /// Parallel surfaces have the same normals, so the wall is sampled at the hand's position; this also works in
  /// narrow hollows. Returns false if the position is unknown; `seated` is then unchanged. `alone`: no other tissue
  /// is near, and `set` holds this contact.
  bool seat(const SurfacePatch& patch, const dvec3& target, const dvec3& c, dvec3& seated, ContactSet& set,
            bool& alone) const noexcept;
  static constexpr double kMostSeated = 1.5;  // voxels, limit of the distance of the new position from `c`

  /// For a head that overlaps tissue by more than `kSunk`, which no hand can cause. From the head's centre and from
  /// each sample inside the tissue, finds the nearest point outside, as far as the field stores distances. Without
  /// such a point, `set` gets no contact.
  void find_way_out(const SurfacePatch& patch, const Pose& X_VT, ContactSet& set) const noexcept;
  static constexpr double kSunk = 1.5;  // voxels, limit of the overlap

  /// Updates normals and gaps of the same surface points for a head that has moved a little, without a query.
  void relinearize(const Pose& X_VT, ContactSet& set) const noexcept;

  /// For a head that removed all tissue at pose `X_VE` and is now at `X_VT`. Surface points inside the head at `X_VE`
  /// are interpolation errors, so this function moves them to the head's surface at `X_VE`. Contacts that are refined
  /// later are corrected in the same way.
  void project_out(const Pose& X_VE, const Pose& X_VT, ContactSet& set) const noexcept;

  /// Makes one contact exact on a smooth surface: cubic queries move the contact to the point where head and surface
  /// are closest. Returns false if nothing changed, for example because the contact is still exact. `fine`: accurate
  /// to a hundredth of a degree, for a head that does not cut.
  bool refine(const SurfacePatch& patch, const Pose& X_VT, ContactSet& set, int i, bool fine = false) const noexcept;

  /// Updates normal and gap of a known contact for the head at X_VT, without a query.
  void update_contact(const Pose& X_VT, ContactPlane& plane) const noexcept;

 private:
  bool touch_with_rim(const SurfacePatch& patch, const Pose& X_VT, ContactPlane& plane) const noexcept;
  dvec3 farthest(const Pose& X_VT, const dvec3& along) const noexcept;
  bool find_by_offset(const SurfacePatch& patch, const dvec3& c, ContactSet& set) const noexcept;
  bool find_in_crease(const SurfacePatch& patch, const dvec3& c, double near, ContactSet& set) const noexcept;
  double head_distance(const Pose& X_VT, const dvec3& x, dvec3& n) const noexcept;

  HeadField head_;  // voxels
  bool sphere_;
  double radius_, reach_;                 // voxels
  std::unique_ptr<HeadSamples> samples_;  // voxels
};

}  // namespace typodont::haptics
