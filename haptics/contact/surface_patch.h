// Tissue around the tool in which the servo computes contact and cuts: filled by the carver, then the servo's. Small
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

/// n³ samples of distance (voxels) and label; z fastest.
struct SurfacePatch : Snapshot {
  glm::ivec3 lo{0};  // position of sample (0,0,0) in voxels
  int n = 0;
  bool whole = false;   // contains all tissue: only air beyond
  double band = 1e300;  // voxels, largest stored distance
  // outside never too large, except near cuts and fillings
  bool exact_outside = false;
  // inclusive, around all cuts and fillings
  glm::ivec3 cut_lo{INT_MAX}, cut_hi{INT_MIN};
  glm::ivec3 filled_lo{INT_MAX}, filled_hi{INT_MIN};  // inclusive, around all fillings
  SlidingBuffer<float> distance;
  SlidingBuffer<Tissue> tissue;  // label of each sample (label.h)
  // dense_tissue.h; filled: as before. Empty without hardness per voxel (TissueVolume::graded): kOwnHardness.
  SlidingBuffer<std::uint8_t> hardness;
  // One, if a tool has a shank: every `every`-th sample of a larger region, in its own larger voxels.
  std::vector<SurfacePatch> coarse_levels;
  int every = 1;
  // For reuse by the carver: what stays is kept, only new and changed samples are copied. copied_at:
  // TissueVolume::mark() of the last copy, 0: copy all; written_lo, written_hi: inclusive, by the servo since.
  std::uint64_t copied_at = 0;
  glm::ivec3 written_lo{INT_MAX}, written_hi{INT_MIN};
  // If Snapshot::from is not 0: what comes in; the arrays then mean nothing.
  PatchStep step;

  void resize(int edge) {
    n = edge;
    const std::size_t count = static_cast<std::size_t>(edge) * edge * edge;
    distance.assign(count, 0);
    tissue.assign(count, Tissue::kAir);
  }
  /// For tissue with hardness per voxel.
  void grade() { hardness.resize(tissue.size()); }
  /// To start at voxel `first`. What stays keeps its values; the rest is unspecified.
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
  /// All samples within `reach` of p (voxels), and all that cubic interpolation there reads.
  bool holds(const dvec3& p_V, double reach) const {
    if (number == 0) return false;
    const dvec3 q = p_V - dvec3(lo);
    const double room = reach + kStencil, top = n - 1 - room;
    return q.x >= room && q.y >= room && q.z >= room && q.x <= top && q.y <= top && q.z <= top;
  }
  /// All tissue within `reach` of p, for searches that read nothing else.
  bool covers(const dvec3& p_V, double reach) const { return holds(p_V, reach) || (whole && number != 0); }
  /// Largest `reach` of covers() at p (voxels).
  double reach_around(const dvec3& p_V) const {
    if (whole) return 1e300;
    const dvec3 low = p_V - dvec3(lo), nearest = glm::min(low, dvec3(n - 1) - low);
    return std::min({nearest.x, nearest.y, nearest.z}) - kStencil;
  }
  /// The nearest point that linear interpolation may read.
  dvec3 nearest_held(const dvec3& p_V) const {
    return glm::clamp(p_V, dvec3(lo) + kStencil, dvec3(lo + n - 1) - kStencil);
  }
  /// 0..1 of `way` (voxels) from p along which holds() for `reach`. True at p required.
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
  static constexpr double kStencil = 3;  // voxels, of samples that cubic interpolation reads
};

/// By samples that the servo has written.
inline void mark_written(SurfacePatch& patch, const glm::ivec3& lo, const glm::ivec3& hi) {
  patch.written_lo = glm::min(patch.written_lo, lo), patch.written_hi = glm::max(patch.written_hi, hi);
}
/// By `lo` to `hi`.
inline void mark_cut(SurfacePatch& patch, const glm::ivec3& lo, const glm::ivec3& hi) {
  patch.cut_lo = glm::min(patch.cut_lo, lo), patch.cut_hi = glm::max(patch.cut_hi, hi);
}
/// No cut has changed the field around p (voxels): interpolated samples and the nearest tissue are outside the cuts'
/// box. `distance`: at p.
inline bool is_true_around(const SurfacePatch& patch, const dvec3& p_V, double distance) {
  // voxels to the farthest sample of cubic interpolation (3√3)
  constexpr double kStencil = 5.2;
  if (!patch.exact_outside) return false;
  if (patch.cut_lo.x > patch.cut_hi.x) return true;
  const dvec3 off = glm::max(glm::max(dvec3(patch.cut_lo) - p_V, p_V - dvec3(patch.cut_hi)), dvec3(0));
  return glm::length(off) > distance + 2 * kStencil;
}

/// Voxels.
struct FieldSample {
  double value = 0;
  dvec3 gradient{0, 0, 0};
};

// Unchecked: holds() first.

/// Trilinear at p_V (voxels): error h²/4R for surface radius R, voxel h; 3–4 ns. For searches, never for a force.
/// Beyond a whole patch a lower bound.
double sample_linear(const SurfacePatch& patch, const dvec3& p_V) noexcept;
/// Trilinear with gradient, also beyond a whole patch.
FieldSample sample_linear_gradient(const SurfacePatch& patch, const dvec3& p_V) noexcept;
/// Quasi-interpolating cubic B-spline on 6³ samples at p_V (voxels): C², exact for cubics, O(h⁴). The prefilter is
/// local, in the weights: nothing to update after a cut (Condat, Blu & Unser 2005, sec. III).
FieldSample sample_cubic(const SurfacePatch& patch, const dvec3& p_V) noexcept;

/// Trilinear weights of the eight labels, without air, scaled to 1; in air 0.
PerTissue sample_tissue(const SurfacePatch& patch, const dvec3& p_V) noexcept;

/// If all eight labels agree, their tissue (weight 1), otherwise kAir.
Tissue sole_tissue(const SurfacePatch& patch, const dvec3& p_V) noexcept;

/// Weights of sample_tissue() times hardness (dense_tissue.h); without hardness per voxel the weights.
PerTissue sample_hardness(const SurfacePatch& patch, const dvec3& p_V) noexcept;

/// Nearest voxel, which the patch must contain.
inline Tissue tissue_at(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  const dvec3 q = p_V - dvec3(patch.lo) + 0.5;
  return shown(patch.tissue[patch.at(static_cast<int>(q.x), static_cast<int>(q.y), static_cast<int>(q.z))]);
}

/// Samples along an edge: the tools' reach, interpolation, and the way during the next patch's preparation. Whole
/// leaves, so it is copied by leaf.
int patch_edge_for(std::span<const Tool> tools, double voxel);
/// Voxels from the centre until the tool leaves it.
double patch_travel_for(std::span<const Tool> tools, double voxel);
/// Empty, number 0, of `edge` samples along each axis; with a coarse patch if a tool has a shank.
SurfacePatch empty_patch_for(std::span<const Tool> tools, double voxel, int edge);
/// Of patch_edge_for().
SurfacePatch empty_patch_for(std::span<const Tool> tools, double voxel);

/// The sample's byte, or the filling's. Only with hardness per voxel.
inline std::uint8_t felt_hardness(const SurfacePatch& patch, std::size_t at) noexcept {
  return is_filled(patch.tissue[at]) ? kOwnHardness : patch.hardness[at];
}
/// 0..1 of the nearest voxel, which the patch must contain.
inline double hardness_at(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  if (patch.hardness.empty()) return 1;
  const dvec3 q = p_V - dvec3(patch.lo) + 0.5;
  return hardness_fraction(
      felt_hardness(patch, patch.at(static_cast<int>(q.x), static_cast<int>(q.y), static_cast<int>(q.z))));
}

}  // namespace typodont::haptics
