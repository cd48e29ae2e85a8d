// Makes cuts and fillings in a tissue patch, and transfers them to a newer patch.
#include "haptics/cutting/carve.h"

#include <algorithm>
#include <cstddef>

#include "engine/base/dispatch.h"
#include "haptics/cutting/cut_front.h"
#include "haptics/cutting/inside_fraction.h"
#include "haptics/cutting/lanes.h"
#include "haptics/cutting/voxel_stamp.h"
#include "haptics/dense_tissue.h"
#include "haptics/fill.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

namespace {

/// Sets each sample to the larger of its values in two distance fields.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void take_greater(float* to, const float* from, const int* size, std::ptrdiff_t edge) {
  for (int x = 0; x < size[0]; ++x) {
    for (int y = 0; y < size[1]; ++y) {
      float* const a = to + (x * edge + y) * edge;
      const float* const b = from + (x * edge + y) * edge;
      __builtin_prefetch(a + 4 * edge, 1);
      int i = 0;
      for (; i + 8 <= size[2]; i += 8) {
        const F8 mine = *reinterpret_cast<const F8*>(a + i), other = *reinterpret_cast<const F8*>(b + i);
        *reinterpret_cast<F8*>(a + i) = mine > other ? mine : other;
      }
      for (; i < size[2]; ++i) a[i] = std::max(a[i], b[i]);
    }
  }
}

// voxels around a changed sample within which labels may change
constexpr int kRelabelled = 1;

/// Updates the labels of filled samples after distances have changed.
bool relabel(TissuePatch& patch, const glm::ivec3& changed_lo, const glm::ivec3& changed_hi) {
  const glm::ivec3 lo = glm::max(glm::max(changed_lo - kRelabelled, patch.filled_lo), patch.lo + 1);
  const glm::ivec3 hi = glm::min(glm::min(changed_hi + kRelabelled, patch.filled_hi), patch.lo + patch.n - 2);
  if (lo.x > hi.x || lo.y > hi.y || lo.z > hi.z) return false;
  const std::size_t at = patch.at(lo.x - patch.lo.x, lo.y - patch.lo.y, lo.z - patch.lo.z);
  const std::ptrdiff_t edge = patch.n;
  return restore_labels(hi - lo + 1, patch.distance.data() + at, patch.tissue.data() + at, edge * edge, edge);
}

/// Cuts in a box of the tissue patch. make(a, b, removed) changes the distances in the box a to b (by a moving head, or
/// by removing whole voxels), and returns true if a sample changed.
template <class Make>
PerTissue carve_box(TissuePatch& patch, const glm::ivec3& lo, const glm::ivec3& hi, bool* changed, CutFront* front,
                    PerTissue* hardened, Make make) noexcept {
  if (changed) *changed = false;
  if (hardened) *hardened = {};
  const glm::ivec3 a = glm::max(lo - patch.lo, 0), b = glm::min(hi - patch.lo, patch.n - 1);
  if (a.x > b.x || a.y > b.y || a.z > b.z) return {};
  RemovedVolume removed;
  const bool graded = hardened && !patch.hardness.empty();
  const bool filled = patch.filled_lo.x <= patch.filled_hi.x;
  if (graded) removed.graded = {patch.distance.data(), filled ? patch.tissue.data() : nullptr, patch.hardness.data()};
  if (make(a, b, removed)) {
    mark_cut(patch, a + patch.lo, b + patch.lo);
    mark_written(patch, a + patch.lo - kRelabelled, b + patch.lo + kRelabelled);
    if (relabel(patch, a + patch.lo, b + patch.lo) && front) front->renew_lists();
    if (changed) *changed = true;
  }
  removed.volume[0] = 0;
  if (hardened && !graded) *hardened = removed.volume;
  for (std::size_t i = 1; i < removed.hardened.size() && graded; ++i)
    (*hardened)[i] = static_cast<double>(removed.hardened[i]) * kFractionUnit / kOwnHardness;
  return removed.volume;
}

}  // namespace

PerTissue carve(TissuePatch& patch, const Sweep& sweep, bool* changed, CutFront* front, PerTissue* hardened) noexcept {
  const std::size_t edge = static_cast<std::size_t>(patch.n);
  return carve_box(patch, sweep.lo(), sweep.hi(), changed, front, hardened,
                   [&](const glm::ivec3& a, const glm::ivec3& b, RemovedVolume& removed) {
                     const std::size_t start = patch.at(a.x, a.y, a.z);
                     return front ? sweep.carve(*front, patch.lo, patch.n, patch.distance.data(), patch.tissue.data(),
                                                &removed)
                                  : sweep.carve(a + patch.lo, b - a + 1, patch.distance.data() + start, edge * edge,
                                                edge, patch.tissue.data() + start, &removed);
                   });
}

PerTissue carve(TissuePatch& patch, const VoxelStamp& stamp, bool* changed, PerTissue* hardened) noexcept {
  const std::size_t edge = static_cast<std::size_t>(patch.n);
  return carve_box(patch, stamp.lo(), stamp.hi(), changed, nullptr, hardened,
                   [&](const glm::ivec3& a, const glm::ivec3& b, RemovedVolume& removed) {
                     const std::size_t start = patch.at(a.x, a.y, a.z);
                     return stamp.carve(a + patch.lo, b - a + 1, patch.distance.data() + start, edge * edge, edge,
                                        patch.tissue.data() + start, &removed);
                   });
}

PerTissue fill(TissuePatch& patch, const Fill& filling, bool* changed) noexcept {
  PerTissue added{};
  *changed = false;
  const glm::ivec3 a = glm::max(filling.lo() - patch.lo, 0), b = glm::min(filling.hi() - patch.lo, patch.n - 1);
  if (a.x > b.x || a.y > b.y || a.z > b.z) return added;
  const std::size_t start = patch.at(a.x, a.y, a.z), edge = static_cast<std::size_t>(patch.n);
  FreshLabels fresh;
  *changed = filling.lower(a + patch.lo, b - a + 1, patch.distance.data() + start, patch.tissue.data() + start,
                           edge * edge, edge, &added, &fresh);
  if (!*changed) return added;
  patch.exact_outside = false;
  mark_written(patch, a + patch.lo - kRelabelled, b + patch.lo + kRelabelled);
  patch.filled_lo = glm::min(patch.filled_lo, a + patch.lo), patch.filled_hi = glm::max(patch.filled_hi, b + patch.lo);
  // Filling only reduces distances, so existing labels stay valid; only the labels of this filling are checked.
  const bool inside = std::min({a.x, a.y, a.z}) > 0 && std::max({b.x, b.y, b.z}) < patch.n - 1;
  if (!inside || !fresh.all()) {
    relabel(patch, a + patch.lo, b + patch.lo);
  } else {
    for (const std::int32_t at : fresh.known()) {
      restore_label(patch.distance.data() + start, patch.tissue.data() + start, at,
                    static_cast<std::ptrdiff_t>(edge * edge), static_cast<std::ptrdiff_t>(edge));
    }
  }
  return added;
}

void merge(TissuePatch& patch, const TissuePatch& old, const glm::ivec3& box_lo, const glm::ivec3& box_hi,
           bool filled) noexcept {
  const glm::ivec3 lo = glm::max(box_lo, glm::max(patch.lo, old.lo));
  const glm::ivec3 hi = glm::min(box_hi, glm::min(patch.lo + patch.n, old.lo + old.n) - 1);
  if (lo.x > hi.x || lo.y > hi.y || lo.z > hi.z) return;
  const glm::ivec3 size = hi - lo + 1;
  const std::size_t at = patch.at(lo.x - patch.lo.x, lo.y - patch.lo.y, lo.z - patch.lo.z);
  const std::size_t old_at = old.at(lo.x - old.lo.x, lo.y - old.lo.y, lo.z - old.lo.z);
  if (!filled) {
    take_greater(patch.distance.data() + at, old.distance.data() + old_at, &size.x, patch.n);
  } else {
    for (int x = 0; x < size.x; ++x) {
      for (int y = 0; y < size.y; ++y) {
        const std::size_t row = patch.at(x, y, 0);
        std::copy_n(old.distance.data() + old_at + row, size.z, patch.distance.data() + at + row);
        std::copy_n(old.tissue.data() + old_at + row, size.z, patch.tissue.data() + at + row);
      }
    }
  }
  mark_merged(patch, lo, hi, filled);
  mark_written(patch, lo - kRelabelled, hi + kRelabelled);
  relabel(patch, lo, hi);
}

void mark_merged(TissuePatch& patch, const glm::ivec3& box_lo, const glm::ivec3& box_hi, bool filled) noexcept {
  const glm::ivec3 lo = glm::max(box_lo, patch.lo), hi = glm::min(box_hi, patch.lo + patch.n - 1);
  if (lo.x > hi.x || lo.y > hi.y || lo.z > hi.z) return;
  mark_cut(patch, lo, hi);
  if (filled) patch.filled_lo = glm::min(patch.filled_lo, lo), patch.filled_hi = glm::max(patch.filled_hi, hi);
}

}  // namespace typodont::haptics
