// Where the head touches: a few planes that bound how it may move.
#pragma once

#include <array>
#include <memory>
#include <utility>

#include "haptics/surface_patch.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// A contact at surface point x: the head must keep n·Δp ≥ -gap. Voxels.
struct ContactPlane {
  dvec3 x{0};         // on the tissue's surface
  dvec3 n{0, 0, 1};   // unit, the way the head is pushed
  double gap = 0;     // distance between head and tissue here, negative where they overlap
  double yields = 1;  // share of the slack that this one gives: less where the tissue is harder than around
  bool rim = false;   // a sharp rim of the head touches here: n is the tissue's, whatever the head's sides are
};

struct HeadSamples;

/// Planes side by side in floats; surface points from where the head's centre was when they were found.
struct RoughPlanes {
  static constexpr int kMax = 256, kBatch = 8;     // so many are looked at side by side
  static constexpr int kRoom = kMax + kBatch;      // the last batch may not be full
  alignas(32) float x[kRoom], y[kRoom], z[kRoom], nx[kRoom], ny[kRoom], nz[kRoom], gap[kRoom], yields[kRoom];
};

/// The contacts of one look. All of them roughly, side by side in floats; the few that hold the head exactly.
class ContactSet {
 public:
  static constexpr int kMax = RoughPlanes::kMax;

  int count() const { return count_; }
  /// Of these the first so many are the head's own; the others were added.
  int own() const { return count_ - added_; }
  /// A contact of another part of the tool, which never yields. False when there is no more room.
  bool add(const ContactPlane& plane) noexcept;
  void drop_added() noexcept { count_ -= std::exchange(added_, 0); }
  /// Voxels² of the head that lies on tissue, and the sum of area × outward normal of the tissue there.
  double engaged_area() const { return engaged_area_; }
  const dvec3& engaged_normal() const { return engaged_normal_; }
  /// The deepest overlap, voxels; 0 where there is none.
  double deepest() const { return deepest_; }

  /// One of them: exact where it was refined, else as found.
  ContactPlane plane(int i) const noexcept;
  /// A voxel deep in the tissue at one of them, as found.
  dvec3 below(int i) const noexcept {
    return origin_ + dvec3(rough_.x[i] - rough_.nx[i], rough_.y[i] - rough_.ny[i], rough_.z[i] - rough_.nz[i]);
  }
  void set_yields(int i, double yields) noexcept;
  void clear() noexcept;
  const RoughPlanes& rough() const { return rough_; }
  /// The head lies so deep that its own shape says nothing about the way out: see find_way_out().
  bool sunk() const { return sunk_; }
  /// The planes are the flat walls of a groove themselves: exact, from where they were found.
  bool flat() const { return flat_; }

 private:
  friend class ContactFinder;

  struct Exact {
    int index;
    dvec3 c;  // the head's centre when it was made exact
    ContactPlane plane;
  };
  static constexpr int kExact = 12;

  Exact* exact(int i) noexcept;
  void put_beside(const ContactPlane& rim) noexcept;
  void put(int i, const dvec3& c, const ContactPlane& plane) noexcept;

  int count_ = 0, exact_count_ = 0, added_ = 0;
  bool sunk_ = false, flat_ = false;
  double engaged_area_ = 0, deepest_ = 0;
  dvec3 engaged_normal_{0};
  dvec3 origin_{0};  // of the rough planes' points
  bool forgiving_ = false;
  Pose emptied_;  // where the head is known to have emptied its place; voxels
  RoughPlanes rough_{};
  std::array<Exact, kExact> exact_;
};

/// Finds the contacts of one head. Built at set-up; find() is servo-safe.
class ContactFinder {
 public:
  ContactFinder(const Tool& tool, double voxel);
  ~ContactFinder();
  ContactFinder(ContactFinder&&) noexcept;
  ContactFinder& operator=(ContactFinder&&) noexcept;

  double reach() const { return reach_; }  // voxels, farthest point of the head

  /// Contacts of the head at X_VT (translation in voxels) whose gap is below `near` (voxels, at most about one), one per
  /// sample of the head that has tissue near, or a single exact one where the offset surface is smooth. The patch must
  /// hold the head.
  void find(const SurfacePatch& patch, const Pose& X_VT, double near, ContactSet& set) const noexcept;

  /// Where a ball that is pulled from `c` to `target` (voxels) comes to rest if one smooth wall holds it. Walls that are
  /// parallel have their normals in common, so the wall is looked up where the hand is, however narrow the hollow that
  /// the ball itself lies in. False, and `seated` untouched, where that is not known. `alone`: nothing else of the tissue is
  /// near, and `set` holds that contact.
  bool seat(const SurfacePatch& patch, const dvec3& target, const dvec3& c, dvec3& seated, ContactSet& set,
            bool& alone) const noexcept;
  static constexpr double kMostSeated = 1.5;  // voxels from where the ball was

  /// Of a head that overlaps tissue by more than `kSunk`, put there by no hand: from each of its samples inside, and from
  /// its centre, the nearest way out of the tissue, as far in as the field is a distance. No contact when even that is
  /// not known.
  void find_way_out(const SurfacePatch& patch, const Pose& X_VT, ContactSet& set) const noexcept;
  static constexpr double kSunk = 1.5;  // voxels

  /// The same surface points seen from a head that has moved a little: new normals and gaps, no query.
  void relinearize(const Pose& X_VT, ContactSet& set) const noexcept;

  /// For a head that has emptied its place at `X_VE`, and is now at `X_VT`: surface points that seem to lie in that place do so
  /// by interpolation only, however narrow the cut, and come out to where the head touched them. So do those of contacts
  /// that are made exact later.
  void forgive(const Pose& X_VE, const Pose& X_VT, ContactSet& set) const noexcept;

  /// Makes one contact exact on a smooth surface: slides it, by cubic queries, to where head and surface are closest.
  /// Returns whether it had to: a contact stays exact for a little way. `fine`: to a hundredth of a degree, for a head that
  /// only touches.
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
  double radius_, reach_;             // voxels
  std::unique_ptr<HeadSamples> samples_;  // voxels
};

}  // namespace typodont::haptics
