// Searches the contacts between a head and the tissue; main header of the folder haptics/contact/proxy.
// 1. ContactFinder finds the points at which the head touches tissue, as planes (contact_set.h).
// 2. nearest_allowed() computes the proxy's position nearest to the hand that all planes allow.
// 3. ContactFinder::refine computes the planes that stop the head again, by cubic interpolation. Then step 2 is
// repeated.
// Frames: W workbench, V grid of the tissue patch (voxels), T tool. docs/contact.md explains the method and its errors.
#pragma once

#include <memory>

#include "haptics/contact/proxy/contact_set.h"
#include "haptics/contact/tissue_patch.h"
#include "haptics/tool.h"

namespace typodont::haptics {

struct HeadSamples;

/// Finds the contacts of one head. The object is created at set-up. All its other functions may be called on the servo
/// thread.
class ContactFinder {
 public:
  ContactFinder(const Tool& tool, double voxel);
  ~ContactFinder();
  ContactFinder(ContactFinder&&) noexcept;
  ContactFinder& operator=(ContactFinder&&) noexcept;

  double reach() const { return reach_; }  // voxels, distance from the head's centre to its farthest point

  /// Finds the contacts of the head whose gap is below `near` (voxels, at most about one). The tissue patch must
  /// contain the head. `fine`: for a head that neither cuts nor fills; also searches between the head's surface
  /// samples, and finds contacts at creases of the tissue.
  void find(const TissuePatch& patch, const Pose& X_VT, double near, ContactSet& set, bool fine = false) const noexcept;

  /// Computes the final position of a ball that is pulled from `c` to the hand at `target` (voxels) if one smooth wall
  /// or a known edge stops it; otherwise returns false and leaves `seated` unchanged. `alone`: receives true if no
  /// other tissue is near; `set` then contains this contact.
  bool seat(const TissuePatch& patch, const dvec3& target, const dvec3& c, dvec3& seated, ContactSet& set,
            bool& alone) const noexcept;
  // voxels, largest distance by which seat() may move the ball
  static constexpr double kMaxSeated = 1.5;

  /// Finds contacts for a head that overlaps tissue by more than `kDeepPenetration`, for example after a jump: the
  /// nearest points outside the tissue. If there is none within the field's band, `set` gets no contact.
  void find_way_out(const TissuePatch& patch, const Pose& X_VT, ContactSet& set) const noexcept;
  // voxels; a head with a larger overlap is in deep penetration
  static constexpr double kDeepPenetration = 1.5;

  /// Updates the normals and gaps of the contacts in `set` after a small motion of the head to X_VT, without reading
  /// the field again.
  void relinearize(const Pose& X_VT, ContactSet& set) const noexcept;

  /// Corrects contacts of a head that removed all tissue inside it at the pose `X_VE` and is now at `X_VT`. Surface
  /// points inside the head at `X_VE` are interpolation errors; they are moved to the head's surface.
  void project_out(const Pose& X_VE, const Pose& X_VT, ContactSet& set) const noexcept;

  /// Moves contact `i` to the point where head and tissue are closest, by cubic interpolation. Returns false if nothing
  /// changed. `fine`: the normal is accurate to 0.01 degree, for a head that does not cut.
  bool refine(const TissuePatch& patch, const Pose& X_VT, ContactSet& set, int i, bool fine = false) const noexcept;

  /// Updates normal and gap of one contact for the head at the pose X_VT, without a query of the field.
  void update_contact(const Pose& X_VT, ContactPlane& plane) const noexcept;

 private:
  bool touch_with_rim(const TissuePatch& patch, const Pose& X_VT, ContactPlane& plane) const noexcept;
  dvec3 farthest(const Pose& X_VT, const dvec3& along) const noexcept;
  void find_below(const TissuePatch& patch, const Pose& X_VT, const dvec3& x, double near,
                  ContactSet& set) const noexcept;
  void find_rims(const TissuePatch& patch, const Pose& X_VT, double near, ContactSet& set) const noexcept;
  void find_between_samples(const TissuePatch& patch, const Pose& X_VT, double near, ContactSet& set) const noexcept;
  bool descend(const TissuePatch& patch, const Pose& X_VT, dvec3& x) const noexcept;
  bool touch_crease(const TissuePatch& patch, const Pose& X_VT, const dvec3& near, KnownCreases& known,
                    ContactPlane& plane) const noexcept;
  bool touch(const Crease& crease, const Pose& X_VT, const dvec3& x, ContactPlane& plane) const noexcept;
  bool touch_sheet(const Sheet& sheet, const Pose& X_VT, dvec3 x, ContactPlane& plane) const noexcept;
  bool touch_line(const Crease& crease, int i, int j, const Pose& X_VT, dvec3 x, ContactPlane& plane) const noexcept;
  bool seat_on_crease(const TissuePatch& patch, const dvec3& target, const dvec3& c, dvec3& seated,
                      ContactSet& set) const noexcept;
  bool seat_on_wall(const TissuePatch& patch, const dvec3& target, const dvec3& c, dvec3& seated, ContactSet& set,
                    bool& alone) const noexcept;
  bool find_by_offset(const TissuePatch& patch, const dvec3& c, ContactSet& set) const noexcept;
  bool find_in_crease(const TissuePatch& patch, const dvec3& c, double near, ContactSet& set) const noexcept;
  double head_distance(const Pose& X_VT, const dvec3& x, dvec3& n) const noexcept;

  HeadField head_;  // distance field of the head, in voxels
  bool sphere_;
  // voxels; radius_: radius of a ball; reach_: distance from the head's centre to its farthest point
  double radius_, reach_;
  // voxels, the head's sharp rims and tips (radius 0); a contact nearer to a rim than `beside` belongs to this rim
  struct {
    double radius, z, beside;
  } rims_[HeadField::kMaxPieces + 1];
  int rim_count_ = 0;
  std::unique_ptr<HeadSamples> samples_;  // surface samples of the head, in voxels
};

}  // namespace typodont::haptics
