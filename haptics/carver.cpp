#include "haptics/carver.h"

#include <algorithm>
#include <utility>

#include "engine/base/check.h"
#include "haptics/contact/smooth_contacts.h"
#include "haptics/servo.h"

namespace typodont::haptics {

namespace {

constexpr double kStrokePause = 0.3;  // s without a cut: another stroke

}  // namespace

Carver::Carver(TissueVolume volume, std::span<const Tool> tools)
    : volume_(std::move(volume)), tools_(tools.begin(), tools.end()), watch_(volume_) {
  TYPODONT_CHECK(!tools_.empty());
  const double voxel = volume_.frame().voxel;
  travel_ = patch_travel_for(tools_, voxel) * voxel;
  const WideGrid wide = wide_grid_for(tools_, voxel, travel_ / voxel);
  wide_every_ = wide.every, wide_edge_ = wide.edge;
}

bool Carver::begins_stroke(const Cut& cut) const {
  return !in_stroke_ || cut.t < cut_t_ || to_seconds(cut.t - cut_t_) > kStrokePause;
}

void Carver::rest(Nanos t) {
  if (!in_stroke_ || to_seconds(t - cut_t_) <= kStrokePause) return;
  in_stroke_ = false;
  volume_.end_stroke();
}

void Carver::apply(const Cut& cut) {
  TYPODONT_CHECK(cut.index == cuts_ + 1 && cut.tool < tools_.size());
  if (begins_stroke(cut)) volume_.begin_stroke();
  in_stroke_ = true;
  cut_t_ = cut.t;
  if (cut.fill_radius > 0) {
    const VoxelBox filled =
        volume_.fill(Fill(tools_[cut.tool], cut.X_WA.p, cut.fill_radius, cut.X_WB, volume_.frame()));
    if (!filled.empty()) watch_.after_fill(volume_, filled.lo, filled.hi);
    cuts_ = cut.index;
    end_tool_ = cut.tool;
    return;
  }
  // After an edit the head may stand in tissue that has come back: the sweep starts from its whole ball again.
  const bool edited = edits_ > 0 && cuts_ == edited_at_;
  const bool continues = cuts_ > 0 && !edited && cut.tool == end_tool_ && same(cut.X_WA, end_);
  const VoxelBox carved = volume_.carve(Sweep(tools_[cut.tool], cut.X_WA, cut.X_WB, volume_.frame(), continues));
  cuts_ = cut.index;
  end_ = cut.X_WB;
  end_tool_ = cut.tool;
  if (!carved.empty()) take_out_pieces(cut, carved);
}

void Carver::take_out_pieces(const Cut& cut, const VoxelBox& written) {
  const std::vector<TissuePiece> pieces = watch_.after_cut(volume_, written.lo, written.hi);
  for (const TissuePiece& piece : pieces) {
    LoosePiece loose{cut.index, cut.t, {}, 0, volume_.take_out(piece)};
    dvec3 lo(1e300), hi(-1e300);
    for (const BlockPart& part : piece) {
      lo = glm::min(lo, dvec3(part.key * 8)), hi = glm::max(hi, dvec3(part.key * 8 + 7));
    }
    const dvec3 edges = hi - lo;
    loose.center_W = volume_.frame().to_world((lo + hi) / 2.0);
    loose.radius = std::max({edges.x, edges.y, edges.z}) / 2 * volume_.frame().voxel;
    for (std::size_t i = 0; i < loose_volume_.size(); ++i) loose_volume_[i] += loose.removed[i];
    loose_.push_back(loose);
    ++pieces_;
  }
  watch_.removed(pieces);
}

bool Carver::undo() {
  in_stroke_ = false;  // whether or not there is a stroke to take back, the one being made is over
  return edit(volume_.undo());
}

bool Carver::edit(bool done) {
  if (!done) return false;
  in_stroke_ = false;
  ++edits_;
  edited_at_ = cuts_;
  watch_.after_edit();
  return true;
}

bool Carver::patch_due(const ServoTick& tick) const {
  if (patches_ == 0 || patch_edits_ != edits_ || patch_pieces_ != pieces_) return true;
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
  patch.pieces = patch_pieces_ = pieces_;
  patch.loose = loose_volume_;
  patch.center_W = center_W;
  patch.lo = center - patch.n / 2;
  patch.band = volume_.band() / volume_.frame().voxel;
  patch.exact_outside = volume_.exact_outside();
  volume_.copy_for_patch(patch.lo, glm::ivec3(patch.n), patch.distance.data(), patch.tissue.data());
  center_W_ = center_W;
  if (wide_edge_ > 0 && patch.wide.empty()) {
    patch.wide.emplace_back();
    patch.wide.front().resize(wide_edge_);
    patch.wide.front().every = wide_every_;
  }
  for (SurfacePatch& wide : patch.wide) {
    wide.number = patch.number;
    wide.lo = center / wide_every_ - wide_edge_ / 2;
    wide.band = patch.band / wide_every_;
    wide.exact_outside = patch.exact_outside;
    volume_.copy_every(wide_every_, wide.lo, glm::ivec3(wide_edge_), wide.distance.data(), wide.tissue.data());
  }
  say_where_cut(patch);
}

bool Carver::bring_up_to_date(SurfacePatch& patch) {
  if (patch.number != patches_ || patch_edits_ != edits_ || patch_pieces_ != pieces_) return false;
  const auto whole = [](SurfacePatch& p) {
    return TissueVolume::Copied{p.lo, glm::ivec3(p.n), p.distance.data(), p.tissue.data()};
  };
  const TissueVolume::Copied wide = patch.wide.empty() ? TissueVolume::Copied{} : whole(patch.wide.front());
  volume_.copy_written(whole(patch), wide_every_, patch.wide.empty() ? nullptr : &wide);
  patch.cuts = cuts_;
  say_where_cut(patch);
  return true;
}

void Carver::say_where_cut(SurfacePatch& patch) const {
  volume_.cut_box(patch.lo, patch.lo + patch.n - 1, patch.cut_lo, patch.cut_hi);
  volume_.filled_box(patch.lo, patch.lo + patch.n - 1, patch.filled_lo, patch.filled_hi);
  for (SurfacePatch& wide : patch.wide) {
    volume_.cut_box(wide.lo * wide_every_, (wide.lo + wide_edge_ - 1) * wide_every_, wide.cut_lo, wide.cut_hi);
    if (wide.cut_lo.x > wide.cut_hi.x) continue;
    wide.cut_lo = wide.cut_lo / wide_every_ - 1, wide.cut_hi = wide.cut_hi / wide_every_ + 1;
  }
}

}  // namespace typodont::haptics
