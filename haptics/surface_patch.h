// The dense copy of the tissue in which the servo computes contact and cuts. The carver fills it, then the servo owns
// it.
#pragma once

#include <algorithm>
#include <climits>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/contract/field_brick.h"
#include "haptics/hardness.h"
#include "haptics/label.h"
#include "haptics/sliding_buffer.h"
#include "haptics/snapshot.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// A cube of n³ samples of distance (voxels) and label, z fastest. The carver reuses patches that come back from the
/// servo: a patch that moves keeps the samples that stay inside, and only new and changed samples are copied.
struct SurfacePatch : Snapshot {
  glm::ivec3 lo{0};  // voxel of sample (0,0,0)
  int n = 0;
  double band = 1e300;  // voxels, band: the field stores distances up to this distance from the surface
  // distances outside the tissue never exceed the true distance, except near cuts and fillings
  bool exact_outside = false;
  glm::ivec3 cut_lo{INT_MAX}, cut_hi{INT_MIN};        // box of voxels, inclusive, around all cuts and fillings
  glm::ivec3 filled_lo{INT_MAX}, filled_hi{INT_MIN};  // box of voxels, inclusive, around all fillings
  SlidingBuffer<float> distance;
  SlidingBuffer<Tissue> tissue;  // see label.h
  // Hardness, see hardness.h; for a filled sample the hardness before the filling. Empty if the tissue is not graded
  // (TissueVolume::graded): then every sample has kOwnHardness.
  SlidingBuffer<std::uint8_t> hardness;
  // If a tool has a shank: one coarse patch. It contains every `every`-th sample and a larger region; its lengths are
  // in voxels of its own size.
  std::vector<SurfacePatch> wide;
  int every = 1;
  // The samples that the carver must copy again when it reuses the patch: changes of the tissue since `copied_at`
  // (TissueVolume::mark(); 0: all samples), and the box of voxels, inclusive, in which the servo wrote to the patch.
  std::uint64_t copied_at = 0;
  glm::ivec3 written_lo{INT_MAX}, written_hi{INT_MIN};

  void resize(int edge) {
    n = edge;
    const std::size_t count = static_cast<std::size_t>(edge) * edge * edge;
    distance.assign(count, 0);
    tissue.assign(count, Tissue::kAir);
  }
  /// Allocates the hardness, for a patch of graded tissue.
  void grade() { hardness.resize(tissue.size()); }
  /// Moves the patch so that it begins at voxel `first`. Samples that stay inside keep their values; all other values
  /// are unspecified.
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
  /// True if the patch contains all samples within `reach` voxels of p (in voxels), cubic stencil included.
  bool holds(const dvec3& p_V, double reach) const {
    if (number == 0) return false;
    const dvec3 q = p_V - dvec3(lo);
    const double room = reach + 3, top = n - 1 - room;
    return q.x >= room && q.y >= room && q.z >= room && q.x <= top && q.y <= top && q.z <= top;
  }
  /// The largest `reach` for which holds() is true at p (in voxels).
  double reach_around(const dvec3& p_V) const {
    const dvec3 low = p_V - dvec3(lo), nearest = glm::min(low, dvec3(n - 1) - low);
    return std::min({nearest.x, nearest.y, nearest.z}) - 3;
  }
};

/// Extends the box of samples that the servo wrote to.
inline void mark_written(SurfacePatch& patch, const glm::ivec3& lo, const glm::ivec3& hi) {
  patch.written_lo = glm::min(patch.written_lo, lo), patch.written_hi = glm::max(patch.written_hi, hi);
}
/// Extends the box around all cuts.
inline void mark_cut(SurfacePatch& patch, const glm::ivec3& lo, const glm::ivec3& hi) {
  patch.cut_lo = glm::min(patch.cut_lo, lo), patch.cut_hi = glm::max(patch.cut_hi, hi);
}
/// True if cuts have not changed the field around p (in voxels), whose value there is `distance`: neither the samples
/// of the cubic stencil nor the tissue nearest to them lie in the box of the cuts.
inline bool is_true_around(const SurfacePatch& patch, const dvec3& p_V, double distance) {
  constexpr double kStencil = 5.2;  // voxels, distance from a point to the corners of its stencil, 3√3
  if (!patch.exact_outside) return false;
  if (patch.cut_lo.x > patch.cut_hi.x) return true;
  const dvec3 off = glm::max(glm::max(dvec3(patch.cut_lo) - p_V, p_V - dvec3(patch.cut_hi)), dvec3(0));
  return glm::length(off) > distance + 2 * kStencil;
}

/// Value and gradient of the field at a point, in voxels.
struct FieldSample {
  double value = 0;
  dvec3 gradient{0, 0, 0};
};

// sample_linear(), sample_linear_gradient() and sample_cubic() read the patch without bounds checks: the caller must
// check holds() first.

/// Trilinear value: error h²/4R, 3–4 ns. For searches, never for a force.
double sample_linear(const SurfacePatch& patch, const dvec3& p_V) noexcept;
/// Trilinear value with the gradient of the trilinear interpolation.
FieldSample sample_linear_gradient(const SurfacePatch& patch, const dvec3& p_V) noexcept;
/// Quasi-interpolating cubic B-spline on 6³ samples: C², reproduces cubics, error O(h⁴). The prefilter is local and
/// part of the weights, so a cut needs no update of coefficients (Condat, Blu & Unser 2005, sec. III).
FieldSample sample_cubic(const SurfacePatch& patch, const dvec3& p_V) noexcept;

/// Trilinear weights of the eight labels around a point, without air. The sum is 1, or 0 in air.
PerTissue sample_tissue(const SurfacePatch& patch, const dvec3& p_V) noexcept;

/// The weights of sample_tissue(), each multiplied by the hardness of its voxels (hardness.h). Without hardness: the
/// weights alone.
PerTissue sample_hardness(const SurfacePatch& patch, const dvec3& p_V) noexcept;

/// The label of the voxel nearest to p; the patch must contain this voxel.
inline Tissue tissue_at(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  const dvec3 q = p_V - dvec3(patch.lo) + 0.5;
  return shown(patch.tissue[patch.at(static_cast<int>(q.x), static_cast<int>(q.y), static_cast<int>(q.z))]);
}

/// Edge, in samples, of a patch for these tools. The edge includes the reach of the tools, the stencil, and the
/// distance that the tools may move while the carver works.
int patch_edge_for(std::span<const Tool> tools, double voxel);
/// Distance that a tool may move from the patch's centre before a new patch is due, voxels.
double patch_travel_for(std::span<const Tool> tools, double voxel);
/// Makes an empty patch: number 0, with the edge patch_edge_for(). It contains the coarse patch for shanks if a tool
/// has a shank.
SurfacePatch empty_patch_for(std::span<const Tool> tools, double voxel);

/// The hardness that the hand feels at sample `at`: the sample's byte, or the hardness of a filling there. Only for a
/// patch with hardness.
inline std::uint8_t felt_hardness(const SurfacePatch& patch, std::size_t at) noexcept {
  return is_filled(patch.tissue[at]) ? kOwnHardness : patch.hardness[at];
}
/// The hardness of the voxel nearest to p, 0..1; the patch must contain this voxel.
inline double hardness_at(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  if (patch.hardness.empty()) return 1;
  const dvec3 q = p_V - dvec3(patch.lo) + 0.5;
  return hardness_fraction(
      felt_hardness(patch, patch.at(static_cast<int>(q.x), static_cast<int>(q.y), static_cast<int>(q.z))));
}

}  // namespace typodont::haptics
