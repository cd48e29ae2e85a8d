// The contacts of a head: a few planes that bound how it may move.
#pragma once

#include <array>
#include <utility>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// A contact at surface point x: the head must keep n·Δp ≥ -gap. Voxels.
struct ContactPlane {
  dvec3 x{0};         // on the tissue's surface
  dvec3 n{0, 0, 1};   // unit, the way the head is pushed
  double gap = 0;     // distance between head and tissue here, negative where they overlap
  double yields = 1;  // share of the slack that this one gives: less where the tissue is harder than around
  bool rim = false;   // a sharp rim of the head touches here: n is the tissue's, whatever the head's sides are
};

/// Planes side by side in floats; surface points from where the head's centre was when they were found.
struct RoughPlanes {
  static constexpr int kMax = 256, kBatch = 8;  // so many are looked at side by side
  static constexpr int kRoom = kMax + kBatch;   // the last batch may not be full
  alignas(32) float x[kRoom], y[kRoom], z[kRoom], nx[kRoom], ny[kRoom], nz[kRoom], gap[kRoom], yields[kRoom];
};

/// The contacts of one look. All of them roughly, side by side in floats; the few that hold the head exactly.
class ContactSet {
 public:
  static constexpr int kMax = RoughPlanes::kMax;

  int count() const { return count_; }
  /// Of these the first so many are the head's own; the others were added.
  int own() const { return count_ - added_; }
  /// A contact of another part of the tool, or a plane that leads the head, which never yields. False when there is no
  /// more room.
  bool add(const ContactPlane& plane) noexcept;
  void drop_added() noexcept { count_ -= std::exchange(added_, 0); }
  /// Voxels² of the head within a voxel of tissue, by how near it is; and the sum of area × outward normal of the
  /// tissue of what lies on it now.
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
  void put_beside(const ContactPlane& rim, double within) noexcept;
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

}  // namespace typodont::haptics
