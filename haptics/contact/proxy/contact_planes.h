// Searches the contacts between a head and the tissue. This file is the main header of the folder
// haptics/contact/proxy.
//
// Overview of the folder. The head is the cutting end of the tool. The proxy (god-object) is a pose of the tool that
// stays outside the tissue, as near as possible to the pose of the hand. The picture shows the proxy. A spring between
// the proxy and the hand gives the force. The files of this folder compute the motion of the proxy in three steps:
// 1. Search. The class ContactFinder finds the points where the head touches the tissue or is near it. It reads the
// tissue's distance field in a patch, which is a dense copy of the field around the tool. Each contact becomes a plane
// (ContactPlane, contact_set.h). The plane has a normal n and a gap, which is the distance between head and tissue. A
// displacement Δp of the head is allowed if n·Δp ≥ -gap.
// 2. Projection. The function nearest_allowed() (nearest_allowed.h) computes the position nearest to the hand that all
// planes allow. It uses an active-set method (active_set.h). The active planes are those that stop the head; there are
// at most three.
// 3. Refinement. The search uses single precision and linear interpolation. The active planes are therefore computed
// again with cubic interpolation in double precision (ContactFinder::refine). The projection is then repeated with the
// exact planes.
//
// Special cases. crease.h fits the sheets that meet at an edge, rim or corner of the tissue, and groove.h the walls of
// a groove, because interpolation rounds them. non_cutting_contacts.h computes contacts of the parts of a tool that
// never cut, for example the shank. parameters.h contains all constants with their reasons.
//
// Frames: W is the workbench, V is the grid of the patch (lengths in voxels), and T is the tool with its origin at the
// head's centre and z along its axis. X_VT is the pose of T in V. docs/contact.md explains the method and its errors.
#pragma once

#include <memory>

#include "haptics/contact/proxy/contact_set.h"
#include "haptics/contact/surface_patch.h"
#include "haptics/tool.h"

namespace typodont::haptics {

struct HeadSamples;
struct Crease;
struct Sheet;

/// Finds the contacts of one head. The object is created at set-up. All its other functions may be called on the servo
/// thread.
class ContactFinder {
 public:
  ContactFinder(const Tool& tool, double voxel);
  ~ContactFinder();
  ContactFinder(ContactFinder&&) noexcept;
  ContactFinder& operator=(ContactFinder&&) noexcept;

  double reach() const { return reach_; }  // voxels, distance from the head's centre to its farthest point

  /// Finds the contacts of the head whose gap is below `near` (voxels, at most about one). `X_VT`: pose of the head
  /// (frame T) in the voxel grid (frame V), with the translation in voxels. In general, each surface sample of the head
  /// near tissue gives one contact. For a ball on a smooth offset surface, there is a single exact contact instead. The
  /// patch (copy of the field) must contain the head. `fine`: for a head that neither cuts nor fills, also searches
  /// the tissue between the samples, and refine() finds creases.
  void find(const SurfacePatch& patch, const Pose& X_VT, double near, ContactSet& set,
            bool fine = false) const noexcept;

  /// Computes the final position of a ball that is pulled from `c` to the hand's position `target` (voxels), if one
  /// smooth wall stops it. The field is queried at the hand's position inside the wall. Parallel surfaces have the same
  /// normals, so this query gives the ball's position on the wall, even on narrow concave surfaces. Returns false if
  /// the position cannot be computed; `seated` is then unchanged. `alone`: true if there is no other tissue nearby;
  /// `set` then contains this contact.
  bool seat(const SurfacePatch& patch, const dvec3& target, const dvec3& c, dvec3& seated, ContactSet& set,
            bool& alone) const noexcept;
  // voxels, largest allowed distance between the computed position of the ball and `c`
  static constexpr double kMostSeated = 1.5;

  /// Finds contacts for a head that overlaps tissue by more than `kSunk`, for example after a jump; no hand can press
  /// it so deep. From the head's centre and from each surface sample inside the tissue, searches the nearest point
  /// outside the tissue, as far as the field stores distances. If there is no such point, `set` gets no contact.
  void find_way_out(const SurfacePatch& patch, const Pose& X_VT, ContactSet& set) const noexcept;
  // voxels; a head that overlaps tissue by more than this counts as sunk
  static constexpr double kSunk = 1.5;

  /// Updates the normals and gaps of the contacts in `set` after a small motion of the head, without a new query of the
  /// field.
  void relinearize(const Pose& X_VT, ContactSet& set) const noexcept;

  /// Corrects contacts of a head that removed all tissue inside it at pose `X_VE` and is now at pose `X_VT`. A surface
  /// point inside the head at `X_VE` can only be an interpolation error, so it is moved to the head's surface at
  /// `X_VE`. Contacts that are refined later are corrected in the same manner.
  void project_out(const Pose& X_VE, const Pose& X_VT, ContactSet& set) const noexcept;

  /// Makes contact `i` exact on a smooth surface. Cubic queries of the field move the contact point to the position
  /// where head and surface are closest. Returns false if nothing changed, for example because the contact was already
  /// exact. `fine`: true: the normal is accurate to 0.01 degree, as a head that does not cut needs it.
  bool refine(const SurfacePatch& patch, const Pose& X_VT, ContactSet& set, int i, bool fine = false) const noexcept;

  /// Updates normal and gap of one contact for the head at the pose X_VT, without a query of the field.
  void update_contact(const Pose& X_VT, ContactPlane& plane) const noexcept;

 private:
  bool touch_with_rim(const SurfacePatch& patch, const Pose& X_VT, ContactPlane& plane) const noexcept;
  dvec3 farthest(const Pose& X_VT, const dvec3& along) const noexcept;
  void find_below(const SurfacePatch& patch, const Pose& X_VT, const dvec3& x, double near,
                  ContactSet& set) const noexcept;
  void find_between_samples(const SurfacePatch& patch, const Pose& X_VT, double near, ContactSet& set) const noexcept;
  bool descend(const SurfacePatch& patch, const Pose& X_VT, dvec3& x) const noexcept;
  bool touch_crease(const SurfacePatch& patch, const Pose& X_VT, const dvec3& near, ContactPlane& plane) const noexcept;
  bool touch_sheet(const Sheet& sheet, const Pose& X_VT, dvec3 x, ContactPlane& plane) const noexcept;
  bool touch_line(const Crease& crease, int i, int j, const Pose& X_VT, dvec3 x, ContactPlane& plane) const noexcept;
  bool find_by_offset(const SurfacePatch& patch, const dvec3& c, ContactSet& set) const noexcept;
  bool find_in_crease(const SurfacePatch& patch, const dvec3& c, double near, ContactSet& set) const noexcept;
  double head_distance(const Pose& X_VT, const dvec3& x, dvec3& n) const noexcept;

  HeadField head_;  // distance field of the head, in voxels
  bool sphere_;
  // voxels; radius_: radius of a ball; reach_: distance from the head's centre to its farthest point
  double radius_, reach_;
  std::unique_ptr<HeadSamples> samples_;  // surface samples of the head, in voxels
};

}  // namespace typodont::haptics
