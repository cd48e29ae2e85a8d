#include "haptics/carver.h"

#include <algorithm>
#include <utility>

#include "engine/base/check.h"
#include "haptics/servo.h"

namespace typodont::haptics {

namespace {

constexpr double kStrokePause = 0.3;  // s without a cut: another stroke

}  // namespace

Carver::Carver(TissueVolume volume, std::span<const Tool> tools)
    : volume_(std::move(volume)), tools_(tools.begin(), tools.end()) {
  TYPODONT_CHECK(!tools_.empty());
  const double voxel = volume_.frame().voxel;
  travel_ = patch_travel_for(tools_, voxel) * voxel;
}

bool Carver::begins_stroke(const Cut& cut) const {
  return !in_stroke_ || cut.t < cut_t_ || to_seconds(cut.t - cut_t_) > kStrokePause;
}

void Carver::apply(const Cut& cut) {
  TYPODONT_CHECK(cut.index == cuts_ + 1 && cut.tool < tools_.size());
  if (begins_stroke(cut)) volume_.begin_stroke();
  in_stroke_ = true;
  cut_t_ = cut.t;
  if (cut.fill_radius > 0) {
    volume_.fill(Fill(tools_[cut.tool], cut.X_WA.p, cut.fill_radius, cut.X_WB, volume_.frame()));
    cuts_ = cut.index;
    end_tool_ = cut.tool;
    return;
  }
  // After an edit the head may stand in tissue that has come back: the sweep starts from its whole ball again.
  const bool edited = edits_ > 0 && cuts_ == edited_at_;
  const bool continues = cuts_ > 0 && !edited && cut.tool == end_tool_ && same(cut.X_WA, end_);
  volume_.carve(Sweep(tools_[cut.tool], cut.X_WA, cut.X_WB, volume_.frame(), continues));
  cuts_ = cut.index;
  end_ = cut.X_WB;
  end_tool_ = cut.tool;
}

bool Carver::edit(bool done) {
  if (!done) return false;
  in_stroke_ = false;
  ++edits_;
  edited_at_ = cuts_;
  return true;
}

bool Carver::patch_due(const ServoTick& tick) const {
  if (patches_ == 0 || patch_edits_ != edits_) return true;
  return patch_due_for(patch_center(tick), center_W_, travel_);
}

dvec3 Carver::patch_center(const ServoTick& tick) const {
  return patch_center_for(tick.X_WG.p, tick.X_WT.p, travel_);
}

void Carver::cut_out(const dvec3& center_W, SurfacePatch& patch) {
  const glm::ivec3 center(glm::round(volume_.frame().to_voxels(center_W)));
  patch.number = ++patches_;
  patch.cuts = cuts_;
  patch.edits = patch_edits_ = edits_;
  patch.edited_at = edited_at_;
  patch.taken_back = volume_.taken_back();
  patch.center_W = center_W;
  patch.lo = center - patch.n / 2;
  const glm::ivec3 hi = patch.lo + patch.n - 1;
  patch.exact_outside = volume_.exact_outside();
  volume_.cut_box(patch.lo, hi, patch.cut_lo, patch.cut_hi);
  volume_.copy(patch.lo, glm::ivec3(patch.n), patch.distance.data(), patch.tissue.data());
  center_W_ = center_W;
}

}  // namespace typodont::haptics
