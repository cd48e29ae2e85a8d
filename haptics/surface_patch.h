// The patch: the dense copy of the tissue around the tool, in which the servo computes contact and cuts. The carver
// (owner of the tissue) fills it; then it belongs to the servo. When a small patch then moves, the carver passes only
// the samples that come in (patch_step.h).
#pragma once

#include <algorithm>
#include <climits>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "haptics/hardness.h"
#include "haptics/label.h"
#include "haptics/patch_step.h"
#include "haptics/sliding_buffer.h"
#include "haptics/snapshot.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// A cube of n³ samples of distance (voxels) and label; z runs fastest.
struct SurfacePatch : Snapshot {
  glm::ivec3 lo{0};  // position of sample (0,0,0) in voxels
  int n = 0;
  double band = 1e300;  // voxels, largest distance from the surface that the field stores
  // true: outside the tissue, a stored distance is never larger than the true distance, except near cuts and fillings
  bool exact_outside = false;
  // corners of the box of voxels (inclusive) around all cuts and fillings
  glm::ivec3 cut_lo{INT_MAX}, cut_hi{INT_MIN};
  glm::ivec3 filled_lo{INT_MAX}, filled_hi{INT_MIN};  // corners of the box of voxels (inclusive) around all fillings
  SlidingBuffer<float> distance;
  SlidingBuffer<Tissue> tissue;  // label of each sample (label.h)
  // Hardness of each sample (hardness.h); for a filled sample, the hardness before the filling. Empty if the tissue has
  // no hardness per voxel (TissueVolume::graded); every sample then has kOwnHardness.
  SlidingBuffer<std::uint8_t> hardness;
  // One coarse patch (copy of the tissue) if a tool has a shank, otherwise empty. The coarse patch contains one of
  // every `every` samples along each axis, and covers a larger region than the patch. Its lengths are in its own,
  // larger voxels.
  std::vector<SurfacePatch> coarse_levels;
  int every = 1;
  // The carver reuses a patch that the servo returns: it moves the patch, keeps the samples that stay inside, and
  // copies only new and changed samples. copied_at: state of the tissue when the patch was copied last
  // (TissueVolume::mark(); 0: copy all samples). written_lo, written_hi: corners (inclusive) of the box of samples that
  // the servo has written since then.
  std::uint64_t copied_at = 0;
  glm::ivec3 written_lo{INT_MAX}, written_hi{INT_MIN};
  // If Snapshot::from is not 0: the samples that come in. The arrays of the samples then have no meaning.
  PatchStep step;

  void resize(int edge) {
    n = edge;
    const std::size_t count = static_cast<std::size_t>(edge) * edge * edge;
    distance.assign(count, 0);
    tissue.assign(count, Tissue::kAir);
  }
  /// Allocates the array of hardness, for tissue with hardness per voxel.
  void grade() { hardness.resize(tissue.size()); }
  /// Moves the patch (copy of the tissue) such that it starts at voxel `first`. Samples that stay inside keep their
  /// values; all others are unspecified.
  void move_to(const glm::ivec3& first) noexcept {
    const glm::ivec3 by = first - lo;
    const std::ptrdiff_t samples = (static_cast<std::ptrdiff_t>(by.x) * n + by.y) * n + by.z;
    distance.slide(samples);
    tissue.slide(samples);
    hardness.slide(samples);
    lo = first;
  }
  std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(x) * n + static_cast<std::size_t>(y)) * n + static_cast<std::size_t>(z);
  }
  /// Returns true if the patch (copy of the tissue) contains all samples within `reach` voxels of p (voxels), and all
  /// samples that a cubic interpolation at any of these positions reads.
  bool holds(const dvec3& p_V, double reach) const {
    if (number == 0) return false;
    const dvec3 q = p_V - dvec3(lo);
    const double room = reach + kStencil, top = n - 1 - room;
    return q.x >= room && q.y >= room && q.z >= room && q.x <= top && q.y <= top && q.z <= top;
  }
  /// Returns the largest `reach` for which holds() is true at p (voxels).
  double reach_around(const dvec3& p_V) const {
    const dvec3 low = p_V - dvec3(lo), nearest = glm::min(low, dvec3(n - 1) - low);
    return std::min({nearest.x, nearest.y, nearest.z}) - kStencil;
  }
  /// Returns the largest fraction 0..1 of the motion `way` (voxels) from p (voxels) along which holds() is true for
  /// `reach`. It must be true at p.
  double held_fraction(const dvec3& p_V, const dvec3& way, double reach) const {
    const double room = reach + kStencil;
    double fraction = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double q = p_V[axis] - lo[axis], end = way[axis] > 0 ? n - 1 - room : room;
      if (way[axis] != 0) fraction = std::min(fraction, (end - q) / way[axis]);
    }
    return std::max(fraction, 0.0);
  }

 private:
  static constexpr double kStencil = 3;  // voxels, distance within which a cubic interpolation reads samples
};

/// Extends the box of the samples that the servo has written.
inline void mark_written(SurfacePatch& patch, const glm::ivec3& lo, const glm::ivec3& hi) {
  patch.written_lo = glm::min(patch.written_lo, lo), patch.written_hi = glm::max(patch.written_hi, hi);
}
/// Extends the box around all cuts by the box from `lo` to `hi`.
inline void mark_cut(SurfacePatch& patch, const glm::ivec3& lo, const glm::ivec3& hi) {
  patch.cut_lo = glm::min(patch.cut_lo, lo), patch.cut_hi = glm::max(patch.cut_hi, hi);
}
/// Returns true if no cut has changed the field around p (voxels). For this, two things must lie outside the box of the
/// cuts: the samples that the cubic interpolation needs, and the tissue nearest to p. `distance`: value of the field at
/// p.
inline bool is_true_around(const SurfacePatch& patch, const dvec3& p_V, double distance) {
  // voxels, distance from a point to the farthest samples that the cubic interpolation at this point reads (3√3)
  constexpr double kStencil = 5.2;
  if (!patch.exact_outside) return false;
  if (patch.cut_lo.x > patch.cut_hi.x) return true;
  const dvec3 off = glm::max(glm::max(dvec3(patch.cut_lo) - p_V, p_V - dvec3(patch.cut_hi)), dvec3(0));
  return glm::length(off) > distance + 2 * kStencil;
}

/// Value of the field at a point in voxels, and its gradient.
struct FieldSample {
  double value = 0;
  dvec3 gradient{0, 0, 0};
};

// sample_linear(), sample_linear_gradient() and sample_cubic() do not check bounds: the caller must check holds()
// first.

/// Returns the trilinear interpolation of the field at p_V (voxels). Its error is h²/4R for a surface of radius R and a
/// voxel size h; it takes 3–4 ns. It is used for searches, never for a force.
double sample_linear(const SurfacePatch& patch, const dvec3& p_V) noexcept;
/// Returns the trilinear interpolation of the field at p_V (voxels), with its gradient.
FieldSample sample_linear_gradient(const SurfacePatch& patch, const dvec3& p_V) noexcept;
/// Returns the interpolation of the field at p_V (voxels) by a quasi-interpolating cubic B-spline on 6³ samples. It is
/// C² continuous and exact for cubic polynomials, with an error of O(h⁴). The prefilter is local and part of the
/// weights, so no coefficients must be updated after a cut (Condat, Blu & Unser 2005, sec. III).
FieldSample sample_cubic(const SurfacePatch& patch, const dvec3& p_V) noexcept;

/// Returns for each tissue the sum of the trilinear weights of the eight labels around a point. Air is omitted, and the
/// result is scaled to the sum 1; in air it is 0.
PerTissue sample_tissue(const SurfacePatch& patch, const dvec3& p_V) noexcept;

/// Returns the tissue of the eight voxels around a point if all of them have the same label, and otherwise kAir.
/// sample_tissue() then is 1 for this tissue.
Tissue sole_tissue(const SurfacePatch& patch, const dvec3& p_V) noexcept;

/// Returns the weights of sample_tissue(), each multiplied by the hardness of its voxels (hardness.h). Without hardness
/// per voxel, returns the weights.
PerTissue sample_hardness(const SurfacePatch& patch, const dvec3& p_V) noexcept;

/// Returns the label of the voxel nearest to p. The patch must contain this voxel.
inline Tissue tissue_at(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  const dvec3 q = p_V - dvec3(patch.lo) + 0.5;
  return shown(patch.tissue[patch.at(static_cast<int>(q.x), static_cast<int>(q.y), static_cast<int>(q.z))]);
}

/// Returns the edge length of a patch (copied tissue) for these tools, in samples. It includes the tools' reach, the
/// samples that an interpolation needs, and the distance that a tool may move while the carver prepares the next patch.
/// A patch consists of whole leaves (8³ samples) of the carver's volume, so it is copied leaf by leaf.
int patch_edge_for(std::span<const Tool> tools, double voxel);
/// Returns the distance in voxels that a tool may move from the centre of its patch before it leaves the patch.
double patch_travel_for(std::span<const Tool> tools, double voxel);
/// Creates an empty patch (copy of the tissue; number 0) with the edge length patch_edge_for(). If a tool has a shank,
/// it includes the coarse patch.
SurfacePatch empty_patch_for(std::span<const Tool> tools, double voxel);

/// Returns the hardness that the hand feels at sample `at`: the sample's hardness byte, or the hardness of the filling
/// there. Only for a patch with hardness per voxel.
inline std::uint8_t felt_hardness(const SurfacePatch& patch, std::size_t at) noexcept {
  return is_filled(patch.tissue[at]) ? kOwnHardness : patch.hardness[at];
}
/// Returns the hardness 0..1 of the voxel nearest to p. The patch must contain this voxel.
inline double hardness_at(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  if (patch.hardness.empty()) return 1;
  const dvec3 q = p_V - dvec3(patch.lo) + 0.5;
  return hardness_fraction(
      felt_hardness(patch, patch.at(static_cast<int>(q.x), static_cast<int>(q.y), static_cast<int>(q.z))));
}

}  // namespace typodont::haptics
