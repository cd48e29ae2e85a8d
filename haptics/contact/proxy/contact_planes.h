// Where the head touches the tissue.
#pragma once

#include <memory>

#include "haptics/contact/proxy/contact_set.h"
#include "haptics/surface_patch.h"
#include "haptics/tool.h"

namespace typodont::haptics {

struct HeadSamples;

/// Finds the contacts of one head. Built at set-up; find() is servo-safe.
class ContactFinder {
 public:
  ContactFinder(const Tool& tool, double voxel);
  ~ContactFinder();
  ContactFinder(ContactFinder&&) noexcept;
  ContactFinder& operator=(ContactFinder&&) noexcept;

  double reach() const { return reach_; }  // voxels, farthest point of the head

  /// Contacts of the head at X_VT (translation in voxels) whose gap is below `near` (voxels, at most about one), one
  /// per sample of the head that has tissue near, or a single exact one where the offset surface is smooth. The patch
  /// must hold the head.
  void find(const SurfacePatch& patch, const Pose& X_VT, double near, ContactSet& set) const noexcept;

  /// Where a ball that is pulled from `c` to `target` (voxels) comes to rest if one smooth wall holds it. Walls that
  /// are parallel have their normals in common, so the wall is looked up where the hand is, however narrow the hollow
  /// that the ball itself lies in. False, and `seated` untouched, where that is not known. `alone`: nothing else of the
  /// tissue is near, and `set` holds that contact.
  bool seat(const SurfacePatch& patch, const dvec3& target, const dvec3& c, dvec3& seated, ContactSet& set,
            bool& alone) const noexcept;
  static constexpr double kMostSeated = 1.5;  // voxels from where the ball was

  /// Of a head that overlaps tissue by more than `kSunk`, put there by no hand: from each of its samples inside, and
  /// from its centre, the nearest way out of the tissue, as far in as the field is a distance. No contact when even
  /// that is not known.
  void find_way_out(const SurfacePatch& patch, const Pose& X_VT, ContactSet& set) const noexcept;
  static constexpr double kSunk = 1.5;  // voxels

  /// The same surface points seen from a head that has moved a little: new normals and gaps, no query.
  void relinearize(const Pose& X_VT, ContactSet& set) const noexcept;

  /// For a head that has emptied its place at `X_VE`, and is now at `X_VT`: surface points that seem to lie in that
  /// place do so by interpolation only, however narrow the cut, and come out to where the head touched them. So do
  /// those of contacts that are made exact later.
  void forgive(const Pose& X_VE, const Pose& X_VT, ContactSet& set) const noexcept;

  /// Makes one contact exact on a smooth surface: slides it, by cubic queries, to where head and surface are closest.
  /// Returns whether it had to: a contact stays exact for a little way. `fine`: to a hundredth of a degree, for a head
  /// that only touches.
  bool refine(const SurfacePatch& patch, const Pose& X_VT, ContactSet& set, int i, bool fine = false) const noexcept;

  /// A contact known from before as it is for the head at X_VT: normal and gap anew, no query.
  void see_again(const Pose& X_VT, ContactPlane& plane) const noexcept;

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
