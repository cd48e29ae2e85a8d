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
  double yields = 1; // share of the slack that this one gives: less where the tissue is harder than around
  bool sunk = false; // the head lies so deep that its own shape says nothing: the way out of the tissue counts
};

struct ContactSet {
  static constexpr int kMax = 256;
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

  /// Contacts of the head at X_VT (translation in voxels) whose gap is below `near` (voxels, at most about one), one per
  /// sample of the head that has tissue near, or a single exact one where the offset surface is smooth. The patch must
  /// hold the head.
  void find(const SurfacePatch& patch, const Pose& X_VT, double near, ContactSet& set) const noexcept;

  /// The same surface points seen from a head that has moved a little: new normals and gaps, no query.
  void relinearize(const Pose& X_VT, ContactSet& set) const noexcept;

  /// Makes one contact exact on a smooth surface: slides it, by cubic queries, to where head and surface are closest.
  void refine(const SurfacePatch& patch, const Pose& X_VT, ContactPlane& plane) const noexcept;

 private:
  bool find_by_offset(const SurfacePatch& patch, const dvec3& c, ContactSet& set) const noexcept;
  template <auto sample>
  ContactPlane slide(const SurfacePatch& patch, const Pose& X_VT, dvec3 x, FieldSample field, int steps) const noexcept;
  double head_distance(const Pose& X_VT, const dvec3& x) const noexcept;
  double head_distance(const Pose& X_VT, const dvec3& x, dvec3& n) const noexcept;

  HeadField head_;  // voxels
  bool sphere_;
  double radius_, reach_;  // voxels
  std::vector<HeadSample> samples_;  // voxels
};

/// Which planes hold the god-object: at most three, with how hard each pushes.
struct ActivePlanes {
  int count = 0;
  int index[3] = {};
  double push[3] = {};
};

/// The point nearest to `target` with n_i·(p - c) ≥ -(gap_i + overlap + slack yields_i) for all planes: the god-object's step. Where no such
/// point exists (a head wedged in its own slot), overlapping planes only keep it from going deeper.
dvec3 nearest_allowed(const ContactSet& set, const dvec3& c, double overlap, double slack, const dvec3& target,
                      ActivePlanes& active) noexcept;

}  // namespace typodont::haptics
