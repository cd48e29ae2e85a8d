#include "haptics/carver.h"

#include <algorithm>
#include <utility>

#include "engine/base/check.h"
#include "haptics/servo.h"

namespace typodont::haptics {

Carver::Carver(TissueVolume volume, std::span<const Tool> tools)
    : volume_(std::move(volume)), tools_(tools.begin(), tools.end()) {
  TYPODONT_CHECK(!tools_.empty());
  const double voxel = volume_.frame().voxel;
  travel_ = patch_travel_for(tools_, voxel) * voxel;
}

void Carver::apply(const Cut& cut) {
  TYPODONT_CHECK(cut.index == cuts_ + 1 && cut.tool < tools_.size());
  const bool continues = cuts_ > 0 && cut.tool == end_tool_ && same(cut.X_WA, end_);
  volume_.carve(Sweep(tools_[cut.tool], cut.X_WA, cut.X_WB, volume_.frame(), continues));
  cuts_ = cut.index;
  end_ = cut.X_WB;
  end_tool_ = cut.tool;
}

bool Carver::patch_due(const ServoTick& tick) const {
  if (patches_ == 0) return true;
  return patch_due_for(patch_center(tick), center_W_, travel_);
}

dvec3 Carver::patch_center(const ServoTick& tick) const {
  return patch_center_for(tick.X_WG.p, tick.X_WT.p, travel_);
}

void Carver::cut_out(const dvec3& center_W, SurfacePatch& patch) {
  const glm::ivec3 center(glm::round(volume_.frame().to_voxels(center_W)));
  patch.number = ++patches_;
  patch.cuts = cuts_;
  patch.center_W = center_W;
  patch.lo = center - patch.n / 2;
  const glm::ivec3 hi = patch.lo + patch.n - 1;
  patch.exact_outside = volume_.exact_outside(patch.lo, hi);
  volume_.copy(patch.lo, glm::ivec3(patch.n), patch.distance.data(), patch.tissue.data());
  center_W_ = center_W;
}

}  // namespace typodont::haptics
