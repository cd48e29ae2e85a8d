#include "haptics/contact/patch_step.h"

#include "haptics/contact/tissue_patch.h"
#include "haptics/volume/leaf_rows.h"

namespace typodont::haptics {

void take_step(TissuePatch& patch, TissuePatch& fresh) noexcept {
  patch.move_to(fresh.lo);
  const std::ptrdiff_t stride_y = patch.n, stride_x = stride_y * stride_y;
  const auto place = [&](std::size_t i) {
    const glm::ivec3 at = fresh.step.leaf(i).lo - patch.lo;
    return patch.at(at.x, at.y, at.z);
  };
  for (std::size_t i = 0; i < fresh.step.size(); ++i) {
    // Prefetches the next leaf's destination while this leaf is copied.
    if (i + 1 < fresh.step.size()) {
      prefetch_rows(patch.distance.data() + place(i + 1), stride_x, stride_y);
      prefetch_rows(patch.tissue.data() + place(i + 1), stride_x, stride_y);
    }
    const PatchStep::Leaf& leaf = fresh.step.leaf(i);
    const PatchStep::Samples samples = fresh.step.samples(i);
    const std::size_t to = place(i);
    if (leaf.one_distance) {
      fill_distances(leaf.distance, patch.distance.data() + to, stride_x, stride_y);
    } else {
      copy_distances(samples.distance, patch.distance.data() + to, stride_x, stride_y);
    }
    if (leaf.one_label) {
      fill_leaf(leaf.label, patch.tissue.data() + to, stride_x, stride_y);
    } else {
      copy_bytes(samples.label, patch.tissue.data() + to, stride_x, stride_y);
    }
    if (patch.hardness.empty()) continue;
    if (leaf.one_label) {
      fill_leaf(leaf.hardness, patch.hardness.data() + to, stride_x, stride_y);
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
