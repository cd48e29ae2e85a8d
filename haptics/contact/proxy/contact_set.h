// The contacts of a head: planes that limit its motion.
#pragma once

#include <array>
#include <utility>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// A contact at surface point x: the head's displacement Δp must satisfy n·Δp ≥ -gap. Lengths in voxels.
struct ContactPlane {
  dvec3 x{0};        // point on the tissue's surface
  dvec3 n{0, 0, 1};  // unit vector, direction in which the contact pushes the head
  double gap = 0;    // distance between head and tissue at x, negative if they overlap
  // 0..1, fraction of the slack that this contact allows; below 1 if its tissue is harder than the tissue being cut.
  double yields = 1;
  bool rim = false;  // true if a sharp rim of the head touches: n is then the tissue's normal
};

/// Planes as arrays of floats, for SIMD. Points are relative to the head's centre at the time of the search.
struct RoughPlanes {
  static constexpr int kMax = 256, kBatch = 8;  // kBatch: number of planes per SIMD operation
  static constexpr int kRoom = kMax + kBatch;   // the last batch may be incomplete
  alignas(32) float x[kRoom], y[kRoom], z[kRoom], nx[kRoom], ny[kRoom], nz[kRoom], gap[kRoom], yields[kRoom];
};

/// The contacts of one search. All of them are stored roughly, as arrays of floats; the few that hold the head are
/// also stored exactly.
class ContactSet {
 public:
  static constexpr int kMax = RoughPlanes::kMax;

  int count() const { return count_; }
  /// Number of the head's own contacts, which come first; add() added the remaining contacts.
  int own() const { return count_ - added_; }
  /// Adds a contact of another part of the tool, or a plane that leads the head. It allows no slack. Returns false if
  /// the set is full.
  bool add(const ContactPlane& plane) noexcept;
  void drop_added() noexcept { count_ -= std::exchange(added_, 0); }
  /// engaged_area(): voxels², area of the head within a voxel of tissue, weighted by nearness. engaged_normal():
  /// voxels², sum of area × outward normal of the tissue, over the part of the head that touches now.
  double engaged_area() const { return engaged_area_; }
  const dvec3& engaged_normal() const { return engaged_normal_; }
  /// Deepest overlap in voxels; 0 if nothing overlaps.
  double deepest() const { return deepest_; }

  /// Returns contact i: the exact contact if it was refined, otherwise the contact as found.
  ContactPlane plane(int i) const noexcept;
  /// A point one voxel below the tissue's surface at contact i.
  dvec3 below(int i) const noexcept {
    return origin_ + dvec3(rough_.x[i] - rough_.nx[i], rough_.y[i] - rough_.ny[i], rough_.z[i] - rough_.nz[i]);
  }
  void set_yields(int i, double yields) noexcept;
  void clear() noexcept;
  const RoughPlanes& rough() const { return rough_; }
  /// True if the head lies so deep that its samples do not show the direction out of the tissue: see find_way_out().
  bool sunk() const { return sunk_; }
  /// True if the planes are the flat walls of a groove: they are exact as found.
  bool flat() const { return flat_; }

 private:
  friend class ContactFinder;

  struct Exact {
    int index;
    dvec3 c;  // the head's centre when the contact was refined
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
  dvec3 origin_{0};  // origin of the rough planes' points
  bool projects_out_ = false;
  Pose emptied_;  // voxels, pose at which the head has removed all tissue; valid if projects_out_
  RoughPlanes rough_{};
  std::array<Exact, kExact> exact_;
};

}  // namespace typodont::haptics
