// Where the head touches: a few planes that bound how it may move.
#pragma once

#include <array>
#include <vector>

#include "haptics/surface_patch.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// A contact at surface point x: the head must keep n·Δp ≥ -gap. Voxels.
struct ContactPlane {
  dvec3 x{0};        // on the tissue's surface
  dvec3 n{0, 0, 1};  // unit, the way the head is pushed
  double gap = 0;    // distance between head and tissue here, negative where they overlap
};

struct ContactSet {
  static constexpr int kMax = 12;
  std::array<ContactPlane, kMax> planes;
  int count = 0;
  double engaged_area = 0;   // voxels² of the head that lies on tissue
  dvec3 engaged_normal{0};   // sum of area × outward normal of the tissue there, voxels²
};

/// Finds the contacts of one head. Built at set-up; find() is servo-safe.
class ContactFinder {
 public:
  ContactFinder(const Tool& tool, double voxel);

  double reach() const { return reach_; }  // voxels, farthest point of the head

  /// Contacts of the head at X_VT (translation in voxels) whose gap is below about a voxel. The patch must hold the
  /// head. Exact on any smooth surface: each contact is slid to where head and surface are closest, by cubic queries.
  void find(const SurfacePatch& patch, const Pose& X_VT, ContactSet& set) const noexcept;

 private:
  bool find_by_offset(const SurfacePatch& patch, const dvec3& c, ContactSet& set) const noexcept;
  double head_distance(const Pose& X_VT, const dvec3& x) const noexcept;
  dvec3 head_normal(const Pose& X_VT, const dvec3& x) const noexcept;

  struct Candidate {
    dvec3 x;
    double gap;
  };

  Tool tool_;
  double voxel_;
  bool sphere_;
  double radius_, reach_;  // voxels
  std::vector<HeadSample> samples_;  // voxels
  mutable std::vector<Candidate> candidates_;
};

/// The point nearest to `target` with n_i·(p - c) ≥ -(gap_i + slack) for all planes: the god-object's step. Writes the
/// multiplier of each plane (0 where it does not push). False when no such point exists; p is then c.
bool nearest_allowed(const ContactSet& set, const dvec3& c, double slack, const dvec3& target, dvec3& p,
                     std::array<double, ContactSet::kMax>& multipliers) noexcept;

}  // namespace typodont::haptics
