#include "haptics/surface_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/contact/cubic.h"
#include "haptics/cut_front.h"
#include "haptics/lanes.h"
#include "haptics/share.h"
#include "haptics/work.h"

namespace typodont::haptics {

namespace {

constinit thread_local std::uint64_t t_queries = 0;
const int kCubicLanes = widest_cubic();

struct Cell {
  int x, y, z;
  double u, v, w;  // 0..1 inside the cell
};

Cell cell_at(const SurfacePatch& patch, const dvec3& p_V) {
  const dvec3 q = p_V - dvec3(patch.lo);  // all positive: inside the patch
  const int x = static_cast<int>(q.x), y = static_cast<int>(q.y), z = static_cast<int>(q.z);
  return {x, y, z, q.x - x, q.y - y, q.z - z};
}

/// The greater of two, over a box of samples.
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

/// Where distances changed in that box.
bool relabel(SurfacePatch& patch, const glm::ivec3& changed_lo, const glm::ivec3& changed_hi) {
  const glm::ivec3 lo = glm::max(glm::max(changed_lo - 1, patch.filled_lo), patch.lo + 1);
  const glm::ivec3 hi = glm::min(glm::min(changed_hi + 1, patch.filled_hi), patch.lo + patch.n - 2);
  if (lo.x > hi.x || lo.y > hi.y || lo.z > hi.z) return false;
  const std::size_t at = patch.at(lo.x - patch.lo.x, lo.y - patch.lo.y, lo.z - patch.lo.z);
  const std::ptrdiff_t edge = patch.n;
  return restore_labels(hi - lo + 1, patch.distance.data() + at, patch.tissue.data() + at, edge * edge, edge);
}

}  // namespace

std::uint64_t queries_of_this_thread() noexcept {
  return t_queries;
}

double sample_linear(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  ++t_queries;
  const Cell c = cell_at(patch, p_V);
  const float* f = patch.distance.data() + patch.at(c.x, c.y, c.z);
  const std::size_t sy = static_cast<std::size_t>(patch.n), sx = sy * sy;
  const auto along_z = [&](std::size_t o) { return f[o] + c.w * (f[o + 1] - f[o]); };
  const double a = along_z(0), b = along_z(sy), d = along_z(sx), e = along_z(sx + sy);
  const double lo = a + c.v * (b - a), hi = d + c.v * (e - d);
  return lo + c.u * (hi - lo);
}

FieldSample sample_linear_gradient(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  ++t_queries;
  const Cell c = cell_at(patch, p_V);
  const float* f = patch.distance.data() + patch.at(c.x, c.y, c.z);
  const std::size_t sy = static_cast<std::size_t>(patch.n), sx = sy * sy;
  const double z00 = f[1] - f[0], z01 = f[sy + 1] - f[sy], z10 = f[sx + 1] - f[sx], z11 = f[sx + sy + 1] - f[sx + sy];
  const double a = f[0] + c.w * z00, b = f[sy] + c.w * z01, d = f[sx] + c.w * z10, e = f[sx + sy] + c.w * z11;
  const double lo = a + c.v * (b - a), hi = d + c.v * (e - d);
  const double gz0 = z00 + c.v * (z01 - z00), gz1 = z10 + c.v * (z11 - z10);
  return {lo + c.u * (hi - lo), {hi - lo, (b - a) + c.u * ((e - d) - (b - a)), gz0 + c.u * (gz1 - gz0)}};
}

FieldSample sample_cubic(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  ++t_queries;
  const Cell c = cell_at(patch, p_V);
  const std::size_t sy = static_cast<std::size_t>(patch.n), sx = sy * sy;
  const double fractions[3] = {c.u, c.v, c.w};
  double out[4];
  cubic(patch.distance.data() + patch.at(c.x - 2, c.y - 2, c.z - 4), sx, sy, fractions, out, kCubicLanes);
  return {out[0], {out[1], out[2], out[3]}};
}

PerTissue sample_tissue(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  const Cell c = cell_at(patch, p_V);
  PerTissue shares{};
  double total = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner >> 2, j = corner >> 1 & 1, k = corner & 1;
    const Tissue tissue = shown(patch.tissue[patch.at(c.x + i, c.y + j, c.z + k)]);
    if (tissue == Tissue::kAir) continue;
    const double weight = (i ? c.u : 1 - c.u) * (j ? c.v : 1 - c.v) * (k ? c.w : 1 - c.w);
    shares[static_cast<std::size_t>(tissue)] += weight;
    total += weight;
  }
  if (total > 0) {
    for (double& share : shares) share /= total;
  }
  return shares;
}

PerTissue sample_hardness(const SurfacePatch& patch, const dvec3& p_V) noexcept {
  if (patch.hardness.empty()) return sample_tissue(patch, p_V);
  const Cell c = cell_at(patch, p_V);
  PerTissue sums{};
  double total = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner >> 2, j = corner >> 1 & 1, k = corner & 1;
    const std::size_t at = patch.at(c.x + i, c.y + j, c.z + k);
    const Tissue tissue = shown(patch.tissue[at]);
    if (tissue == Tissue::kAir) continue;
    const double weight = (i ? c.u : 1 - c.u) * (j ? c.v : 1 - c.v) * (k ? c.w : 1 - c.w);
    sums[static_cast<std::size_t>(tissue)] += weight * hardness_fraction(felt_hardness(patch, at));
    total += weight;
  }
  if (total > 0) {
    for (double& sum : sums) sum /= total;
  }
  return sums;
}

namespace {

/// Keeps the distances of a box of the patch, to tell afterwards what a cut took.
void keep_uncut(SurfacePatch& patch, const glm::ivec3& a, const glm::ivec3& b) noexcept {
  float* to = patch.uncut.data();
  const int length = std::max(b.z - a.z + 1, 0);
  for (int x = a.x; x <= b.x; ++x) {
    for (int y = a.y; y <= b.y; ++y, to += length) std::copy_n(patch.distance.data() + patch.at(x, y, a.z), length, to);
  }
}

/// What was taken since keep_uncut(), every voxel's share times its hardness. In whole units (share.h) times bytes, so
/// that the order does not matter.
PerTissue hardened_since(const SurfacePatch& patch, const glm::ivec3& a, const glm::ivec3& b) noexcept {
  std::array<std::int64_t, kTissueCount> sums{};
  const float* from = patch.uncut.data();
  const int length = std::max(b.z - a.z + 1, 0);
  for (int x = a.x; x <= b.x; ++x) {
    for (int y = a.y; y <= b.y; ++y, from += length) {
      const std::size_t row = patch.at(x, y, a.z);
      const float* const now = patch.distance.data() + row;
      if (std::memcmp(from, now, sizeof(float) * static_cast<std::size_t>(length)) == 0) continue;  // most rows
      for (int z = 0; z < length; ++z) {
        if (from[z] == now[z]) continue;
        const std::size_t at = row + static_cast<std::size_t>(z);
        sums[static_cast<std::size_t>(shown(patch.tissue[at]))] +=
            std::int64_t{units_inside(from[z]) - units_inside(now[z])} * felt_hardness(patch, at);
      }
    }
  }
  PerTissue hardened{};
  for (std::size_t i = 1; i < sums.size(); ++i) hardened[i] = static_cast<double>(sums[i]) * kShareUnit / kOwnHardness;
  return hardened;
}

}  // namespace

PerTissue carve(SurfacePatch& patch, const Sweep& sweep, bool* changed, CutFront* front, PerTissue* hardened) noexcept {
  PerTissue removed{};
  if (changed) *changed = false;
  if (hardened) *hardened = {};
  const glm::ivec3 a = glm::max(sweep.lo() - patch.lo, 0), b = glm::min(sweep.hi() - patch.lo, patch.n - 1);
  if (a.x > b.x || a.y > b.y || a.z > b.z) return removed;
  const std::size_t start = patch.at(a.x, a.y, a.z), edge = static_cast<std::size_t>(patch.n);
  const bool graded = hardened && !patch.hardness.empty();
  // Only samples less than half a voxel outside the head lose volume; the sweep reaches kMargin beyond it.
  constexpr int kSpared = static_cast<int>(Sweep::kMargin - 0.5f);
  const glm::ivec3 from = glm::max(a, sweep.lo() + kSpared - patch.lo),
                   to = glm::min(b, sweep.hi() - kSpared - patch.lo);
  if (graded) keep_uncut(patch, from, to);
  if (front ? sweep.raise(*front, patch.lo, patch.n, patch.distance.data(), patch.tissue.data(), &removed)
            : sweep.raise(a + patch.lo, b - a + 1, patch.distance.data() + start, edge * edge, edge,
                          patch.tissue.data() + start, &removed)) {
    mark_cut(patch, a + patch.lo, b + patch.lo);
    if (graded) *hardened = hardened_since(patch, from, to);  // before labels of fillings go
    if (relabel(patch, a + patch.lo, b + patch.lo) && front) front->list_anew();
    if (changed) *changed = true;
  }
  removed[0] = 0;
  if (hardened && !graded) *hardened = removed;
  return removed;
}

PerTissue fill(SurfacePatch& patch, const Fill& filling, bool* changed) noexcept {
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
  patch.filled_lo = glm::min(patch.filled_lo, a + patch.lo), patch.filled_hi = glm::max(patch.filled_hi, b + patch.lo);
  // A voxel that had its label before has a solid neighbour still: filling only lowers.
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

void merge(SurfacePatch& patch, const SurfacePatch& old, const glm::ivec3& box_lo, const glm::ivec3& box_hi,
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
  mark_cut(patch, lo, hi);
  if (filled) patch.filled_lo = glm::min(patch.filled_lo, lo), patch.filled_hi = glm::max(patch.filled_hi, hi);
  relabel(patch, lo, hi);
}

}  // namespace typodont::haptics
