#include "haptics/patch_step.h"

#include <algorithm>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/lanes.h"
#include "haptics/surface_patch.h"

namespace typodont::haptics {

namespace {

constexpr int n = PatchStep::kSide;

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void copy_rows(const float* from, float* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y) {
  for (int x = 0; x < n; ++x, to += stride_x) {
    for (int y = 0; y < n; ++y, from += n)
      *reinterpret_cast<F8*>(to + y * stride_y) = *reinterpret_cast<const F8*>(from);
  }
}
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void fill_rows(float value, float* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y) {
  for (int x = 0; x < n; ++x, to += stride_x) {
    for (int y = 0; y < n; ++y) *reinterpret_cast<F8*>(to + y * stride_y) = F8{} + value;
  }
}
/// Copies or fills the rows of a leaf whose samples are bytes (labels, hardness).
template <class Byte>
void copy_bytes(const Byte* from, Byte* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y) {
  for (int x = 0; x < n; ++x, to += stride_x) {
    for (int y = 0; y < n; ++y, from += n) std::memcpy(to + y * stride_y, from, n);
  }
}
template <class Byte>
void fill_bytes(Byte value, Byte* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y) {
  for (int x = 0; x < n; ++x, to += stride_x) {
    for (int y = 0; y < n; ++y) std::memset(to + y * stride_y, static_cast<int>(value), n);
  }
}

/// Prefetches the rows of a patch to which a leaf will be copied.
template <class T>
void prefetch_rows(const T* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y) {
  for (int x = 0; x < n; ++x, to += stride_x) {
    for (int y = 0; y < n; ++y) __builtin_prefetch(to + y * stride_y, 1);
  }
}

}  // namespace

void take_step(SurfacePatch& patch, SurfacePatch& fresh) noexcept {
  patch.move_to(fresh.lo);
  const std::ptrdiff_t stride_y = patch.n, stride_x = stride_y * stride_y;
  const auto place = [&](std::size_t i) {
    const glm::ivec3 at = fresh.step.leaf(i).lo - patch.lo;
    return patch.at(at.x, at.y, at.z);
  };
  for (std::size_t i = 0; i < fresh.step.size(); ++i) {
    // While the processor copies a leaf, it already loads the memory to which the next leaf will be copied.
    if (i + 1 < fresh.step.size()) {
      prefetch_rows(patch.distance.data() + place(i + 1), stride_x, stride_y);
      prefetch_rows(patch.tissue.data() + place(i + 1), stride_x, stride_y);
    }
    const PatchStep::Leaf& leaf = fresh.step.leaf(i);
    const PatchStep::Samples samples = fresh.step.samples(i);
    const std::size_t to = place(i);
    if (leaf.one_distance) {
      fill_rows(leaf.distance, patch.distance.data() + to, stride_x, stride_y);
    } else {
      copy_rows(samples.distance, patch.distance.data() + to, stride_x, stride_y);
    }
    if (leaf.one_label) {
      fill_bytes(leaf.label, patch.tissue.data() + to, stride_x, stride_y);
    } else {
      copy_bytes(samples.label, patch.tissue.data() + to, stride_x, stride_y);
    }
    if (patch.hardness.empty()) continue;
    if (leaf.one_label) {
      fill_bytes(leaf.hardness, patch.hardness.data() + to, stride_x, stride_y);
    } else {
      copy_bytes(samples.hardness, patch.hardness.data() + to, stride_x, stride_y);
    }
  }
  static_cast<Snapshot&>(patch) = fresh;
  patch.band = fresh.band;
  patch.exact_outside = fresh.exact_outside;
  patch.cut_lo = fresh.cut_lo, patch.cut_hi = fresh.cut_hi;
  patch.filled_lo = fresh.filled_lo, patch.filled_hi = fresh.filled_hi;
  patch.coarse_levels.swap(fresh.coarse_levels);
}

}  // namespace typodont::haptics
