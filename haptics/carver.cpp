#include "haptics/carver.h"

#include <algorithm>
#include <utility>

#include "engine/base/check.h"
#include "haptics/servo.h"

namespace typodont::haptics {

Carver::Carver(TissueVolume volume, std::vector<Tool> tools)
    : volume_(std::move(volume)), tools_(std::move(tools)), travel_(1e300) {
  TYPODONT_CHECK(!tools_.empty());
  const double voxel = volume_.frame().voxel;
  for (const Tool& tool : tools_) travel_ = std::min(travel_, patch_travel_for(tool, voxel) * voxel);
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
  const dvec3 off = glm::abs(patch_center(tick) - center_W_);
  return std::max({off.x, off.y, off.z}) > travel_ / 2;
}

dvec3 Carver::patch_center(const ServoTick& tick) const {
  const dvec3 pull = tick.X_WT.p - tick.X_WG.p;
  const double length = glm::length(pull);
  return tick.X_WG.p + (length > travel_ / 2 ? pull * (travel_ / 2 / length) : pull);
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
