// A dense copy of the tissue around the tool, in which the servo computes contact and cuts. The carver fills it. Small
// patches move by steps (patch_step.h).
#pragma once

#include <algorithm>
#include <climits>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/contract/field_brick.h"
#include "engine/contract/tissue.h"
#include "haptics/contact/patch_step.h"
#include "haptics/contact/sliding_buffer.h"
#include "haptics/contact/snapshot.h"
#include "haptics/dense_tissue.h"
#include "haptics/tool.h"
#include "haptics/volume/label.h"

namespace typodont::haptics {

/// n³ samples of distance (voxels) and tissue label; z is the fastest index.
struct TissuePatch : Snapshot {
  glm::ivec3 lo{0};  // voxels, position of sample (0,0,0)
  int n = 0;
  bool whole = false;   // true: the tissue patch contains all tissue; outside it there is only air
  double band = 1e300;  // voxels, largest distance from the surface that is stored
  // true: outside the tissue, stored distances are not larger than the true ones, except near cuts and fillings
  bool exact_outside = false;
  // voxels, box around all samples that cuts or fillings have changed, inclusive
  glm::ivec3 cut_lo{INT_MAX}, cut_hi{INT_MIN};
  glm::ivec3 filled_lo{INT_MAX}, filled_hi{INT_MIN};  // voxels; box around all filled samples, inclusive
  SlidingBuffer<float> distance;
  SlidingBuffer<Tissue> tissue;  // label of each sample (label.h)
  // Hardness of each sample (dense_tissue.h); at filled samples, the value before filling. Empty if the tissue has no
  // hardness per voxel (TissueVolume::graded).
  SlidingBuffer<std::uint8_t> hardness;
  // Has one element if a tool has a shank: a larger region that contains every `every`-th sample. Its lengths are in
  // its own, larger voxels.
  std::vector<TissuePatch> coarse_levels;
  int every = 1;
  // Data with which the carver copies only new or changed samples. copied_at: TissueVolume::mark() at the last copy; 0:
  // copy all. written_lo, written_hi: box of the samples that the servo has changed since then, voxels, inclusive.
  std::uint64_t copied_at = 0;
  glm::ivec3 written_lo{INT_MAX}, written_hi{INT_MIN};
  // One element if the model has an intermediate surface (offset/intermediate_surface.h) and the carver copies the
  // whole tissue patch: a second copy of the samples, for the servo. Otherwise empty.
  std::vector<TissuePatch> intermediate;
  // The new samples if Snapshot::from is not 0; the arrays above are then not valid.
  PatchStep step;

  void resize(int edge) {
    n = edge;
    const std::size_t count = static_cast<std::size_t>(edge) * edge * edge;
    distance.assign(count, 0);
    tissue.assign(count, Tissue::kAir);
  }
  /// Allocates the hardness of each voxel.
  void grade() { hardness.resize(tissue.size()); }
  /// Moves the tissue patch so that it starts at voxel `first`. Samples inside both positions keep their values; the
  /// others are unspecified.
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
  /// Returns true if the tissue patch contains all samples within `reach` of p_V (voxels), and the samples around them
  /// that cubic interpolation needs.
  bool holds(const dvec3& p_V, double reach) const {
    if (number == 0) return false;
    const dvec3 q = p_V - dvec3(lo);
    const double margin = reach + kStencil, top = n - 1 - margin;
    return q.x >= margin && q.y >= margin && q.z >= margin && q.x <= top && q.y <= top && q.z <= top;
  }
  /// Returns true if the tissue patch contains all tissue within `reach` of p_V (voxels), although it may lack samples
  /// of air there.
  bool covers(const dvec3& p_V, double reach) const { return holds(p_V, reach) || (whole && number != 0); }
  /// Largest `reach` for which covers() is true at p_V, voxels.
  double reach_around(const dvec3& p_V) const {
    if (whole) return 1e300;
    const dvec3 low = p_V - dvec3(lo), nearest = glm::min(low, dvec3(n - 1) - low);
    return std::min({nearest.x, nearest.y, nearest.z}) - kStencil;
  }
  /// Point nearest to p_V at which linear interpolation reads only stored samples.
  dvec3 nearest_held(const dvec3& p_V) const {
    return glm::clamp(p_V, dvec3(lo) + kStencil, dvec3(lo + n - 1) - kStencil);
  }
  /// Fraction 0..1 of `motion` (voxels) up to which holds(p, reach) is true, if p starts at p_V, where it must be true.
  double held_fraction(const dvec3& p_V, const dvec3& motion, double reach) const {
    const double margin = reach + kStencil;
    double fraction = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double q = p_V[axis] - lo[axis], end = motion[axis] > 0 ? n - 1 - margin : margin;
      if (motion[axis] != 0) fraction = std::min(fraction, (end - q) / motion[axis]);
    }
    return std::max(fraction, 0.0);
  }

 private:
  static constexpr double kStencil = 3;  // voxels around a point that cubic interpolation reads
};

/// Adds the samples from `lo` to `hi`, which the servo has changed, to the box of written samples.
inline void mark_written(TissuePatch& patch, const glm::ivec3& lo, const glm::ivec3& hi) {
  patch.written_lo = glm::min(patch.written_lo, lo), patch.written_hi = glm::max(patch.written_hi, hi);
}
/// Adds the samples from `lo` to `hi` to the box cut_lo..cut_hi of all cuts.
inline void mark_cut(TissuePatch& patch, const glm::ivec3& lo, const glm::ivec3& hi) {
  patch.cut_lo = glm::min(patch.cut_lo, lo), patch.cut_hi = glm::max(patch.cut_hi, hi);
}
/// Distance of p_V from a box; 0 inside. Voxels.
inline double distance_to_box(const glm::ivec3& lo, const glm::ivec3& hi, const dvec3& p_V) {
  return glm::length(glm::max(glm::max(dvec3(lo) - p_V, p_V - dvec3(hi)), dvec3(0)));
}
/// Returns true if no cut has changed the field around p_V (voxels): the samples for interpolation and the nearest
/// tissue lie outside the box of cuts. `distance`: the field at p_V.
inline bool is_true_around(const TissuePatch& patch, const dvec3& p_V, double distance) {
  // voxels, distance of the farthest sample that cubic interpolation reads (3√3)
  constexpr double kStencil = 5.2;
  if (!patch.exact_outside) return false;
  if (patch.cut_lo.x > patch.cut_hi.x) return true;
  return distance_to_box(patch.cut_lo, patch.cut_hi, p_V) > distance + 2 * kStencil;
}

/// Value and gradient of the field, in voxels.
struct FieldSample {
  double value = 0;
  dvec3 gradient{0, 0, 0};
};

// The following functions do not check whether the tissue patch contains the samples around p_V: call holds() first.

/// Trilinear interpolation at p_V (voxels). Error: h²/4R for a surface with radius R and the voxel size h. Takes 3–4
/// ns. For searches, never for a force. Outside a patch that is `whole`: lower bound of the distance.
double sample_linear(const TissuePatch& patch, const dvec3& p_V) noexcept;
/// Lower bound of the distance from p_V to tissue, voxels. Beside fillings, it may be smaller than the field.
double min_distance(const TissuePatch& patch, const dvec3& p_V) noexcept;
/// Trilinear interpolation with gradient. Outside a patch that is `whole`: the result at its nearest point.
FieldSample sample_linear_gradient(const TissuePatch& patch, const dvec3& p_V) noexcept;
/// Quasi-interpolating cubic B-spline on 6³ samples at p_V (voxels): C², exact for cubics, error O(h⁴). Its weights
/// contain the prefilter, so a cut requires no update (Condat, Blu & Unser 2005, sec. III).
FieldSample sample_cubic(const TissuePatch& patch, const dvec3& p_V) noexcept;

/// Tissues at p_V (voxels): trilinear weights of the eight labels around it. Air has no weight; the sum is 1, or 0 in
/// air.
PerTissue sample_tissue(const TissuePatch& patch, const dvec3& p_V) noexcept;

/// Tissue at p_V (voxels) if all eight labels around it are equal; otherwise kAir.
Tissue sole_tissue(const TissuePatch& patch, const dvec3& p_V) noexcept;

/// For each tissue, sum of weight × hardness at p_V (voxels), with the weights of sample_tissue(). If the tissue has no
/// hardness per voxel: only the weights.
PerTissue sample_hardness(const TissuePatch& patch, const dvec3& p_V) noexcept;

/// Tissue of the voxel nearest to p_V (voxels). The tissue patch must contain it.
inline Tissue tissue_at(const TissuePatch& patch, const dvec3& p_V) noexcept {
  const dvec3 q = p_V - dvec3(patch.lo) + 0.5;
  return shown(patch.tissue[patch.at(static_cast<int>(q.x), static_cast<int>(q.y), static_cast<int>(q.z))]);
}

/// Number of samples along an edge of a tissue patch: enough for the reach of all tools, for interpolation, and for the
/// tool's motion until the next patch. A multiple of 8, because patches are copied by leaves of 8³ samples.
int patch_edge_for(std::span<const Tool> tools, double voxel);
/// Distance in voxels that a tool may move from the tissue patch's centre before it needs a new patch.
double patch_travel_for(std::span<const Tool> tools, double voxel);
/// Empty tissue patch (number 0) with `edge` samples along each axis. It has a coarse patch if a tool has a shank.
TissuePatch empty_patch_for(std::span<const Tool> tools, double voxel, int edge);
/// Empty tissue patch with patch_edge_for() samples along each axis.
TissuePatch empty_patch_for(std::span<const Tool> tools, double voxel);

/// Hardness byte of a sample; filling has its own hardness. Only for a tissue patch with hardness per voxel.
inline std::uint8_t felt_hardness(const TissuePatch& patch, std::size_t at) noexcept {
  return is_filled(patch.tissue[at]) ? kOwnHardness : patch.hardness[at];
}
/// Hardness 0..1 of the voxel nearest to p_V (voxels). The tissue patch must contain it.
inline double hardness_at(const TissuePatch& patch, const dvec3& p_V) noexcept {
  if (patch.hardness.empty()) return 1;
  const dvec3 q = p_V - dvec3(patch.lo) + 0.5;
  return hardness_fraction(
      felt_hardness(patch, patch.at(static_cast<int>(q.x), static_cast<int>(q.y), static_cast<int>(q.z))));
}

}  // namespace typodont::haptics
