// The contacts of a head. Each contact is a plane that limits the head's motion.
#pragma once

#include <array>
#include <utility>

#include "haptics/contact/proxy/crease.h"

namespace typodont::haptics {

/// A contact at surface point x. The displacement Δp of the head must satisfy n·Δp ≥ -gap. Lengths in voxels.
struct ContactPlane {
  dvec3 x{0};        // voxels, point of the tissue's surface that touches the head
  dvec3 n{0, 0, 1};  // unit vector, direction in which the contact pushes the head
  double gap = 0;    // voxels between head and tissue at x, negative: overlap
  // fraction 0..1 of the allowed depth by which a cutting head may sink into this contact; below 1 in harder tissue
  double yields = 1;
  bool rim = false;     // true if a sharp rim of the head has contact; n is then the normal of the tissue
  bool crease = false;  // true if x lies on a reconstructed edge, rim or corner of the tissue (crease.h)
};

/// The approximate planes of all contacts, as arrays of floats for SIMD. Points are in voxels, relative to the head's
/// centre at the time of the contact search.
struct ApproximatePlanes {
  // kMax: largest number of planes; kBatch: number of planes per SIMD operation
  static constexpr int kMax = 256, kBatch = 8;
  // size of the arrays: space for a whole SIMD batch after the last plane
  static constexpr int kCapacity = kMax + kBatch;
  alignas(32) float x[kCapacity], y[kCapacity], z[kCapacity], nx[kCapacity], ny[kCapacity], nz[kCapacity],
      gap[kCapacity], yields[kCapacity];
};

/// The contacts of one search, as approximate planes in float arrays. The few that hold the head are also stored as
/// exact planes.
class ContactSet {
 public:
  static constexpr int kMax = ApproximatePlanes::kMax;

  int count() const { return count_; }
  /// Number of the head's own contacts, which come first. The remaining contacts were added by add().
  int own() const { return count_ - added_; }
  /// Adds a contact of another part of the tool, or an artificial plane that limits the head's motion. The head may not
  /// sink into this plane. Returns false if the set is full.
  bool add(const ContactPlane& plane) noexcept;
  void drop_added() noexcept { count_ -= std::exchange(added_, 0); }
  /// engaged_area(): voxels², weighted area of the head's surface within one voxel of tissue. engaged_normal():
  /// voxels², sum of (area × outward normal of the tissue) over the part of the head that touches tissue.
  double engaged_area() const { return engaged_area_; }
  const dvec3& engaged_normal() const { return engaged_normal_; }
  /// Largest overlap of head and tissue at a contact, voxels; 0: none.
  double deepest() const { return deepest_; }

  /// Returns contact i: the exact plane if the contact was refined, otherwise the approximate plane.
  ContactPlane plane(int i) const noexcept;
  /// Point one voxel below the tissue's surface at contact i.
  dvec3 below(int i) const noexcept {
    return origin_ + dvec3(approximate_.x[i] - approximate_.nx[i], approximate_.y[i] - approximate_.ny[i],
                           approximate_.z[i] - approximate_.nz[i]);
  }
  void set_yields(int i, double yields) noexcept;
  /// Removes all contacts.
  void clear() noexcept;
  /// Must be called when the tissue or the head has changed.
  void forget_creases() noexcept { known_.forget(); }
  const ApproximatePlanes& approximate() const { return approximate_; }
  /// Voxels, point to which the positions of the approximate planes are relative.
  const dvec3& origin() const { return origin_; }
  /// Returns true if the head is so deep inside the tissue that ordinary contacts do not show in which direction it can
  /// leave the tissue (see ContactFinder::find_way_out()).
  bool deep_penetration() const { return deep_penetration_; }
  /// Returns true if all contacts are flat walls of a groove; the planes of such walls need no refinement.
  bool flat() const { return flat_; }

 private:
  friend class ContactFinder;

  struct Exact {
    int index;
    dvec3 c;  // voxels, the head's centre when this contact was refined
    ContactPlane plane;
  };
  static constexpr int kExact = 12;

  Exact* exact(int i) noexcept;
  void store(int i, const ContactPlane& plane) noexcept;
  void put_beside(const ContactPlane& rim, double within) noexcept;
  void put(int i, const dvec3& c, const ContactPlane& plane) noexcept;
  void put_rim(const ContactPlane& plane, const dvec3& c, double within) noexcept;
  void put_own(const ContactPlane& plane) noexcept;

  int count_ = 0, exact_count_ = 0, added_ = 0;
  bool deep_penetration_ = false, flat_ = false;
  bool creases_ = false;  // true if refined contacts may lie on a crease (ContactFinder::find)
  double engaged_area_ = 0, deepest_ = 0;
  dvec3 engaged_normal_{0};
  // voxels, head's centre at the time of the search; the points of the approximate planes are relative to it
  dvec3 origin_{0};
  bool projects_out_ = false;
  Pose emptied_;  // voxels, pose at which the head has removed all tissue inside it; valid if projects_out_ is true
  ApproximatePlanes approximate_{};
  KnownCreases known_;
  std::array<Exact, kExact> exact_;
};

}  // namespace typodont::haptics
