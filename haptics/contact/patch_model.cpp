#include "haptics/contact/patch_model.h"

#include <limits>
#include <utility>

#include "haptics/cutting/carve.h"

namespace typodont::haptics {

/// Motion of the tool after which a new tissue patch that has not yet arrived counts as late, m. Twice
/// patch_travel_for(), because a patch may be centred ahead of the tool.
static double reported_travel(const ServoSettings& settings) {
  const double voxel = settings.frame.voxel;
  return 2 * (patch_travel_for(tool_set(settings), voxel) * voxel);
}

PatchModel::PatchModel(const ServoSettings& settings) : settings_(settings), travel_(reported_travel(settings)) {}

void PatchModel::adopt(Snapshot& snapshot, PerTissue& removed) noexcept {
  auto& fresh = static_cast<TissuePatch&>(snapshot);
  // `fresh` is in the cache of another core: prefetch all its cache lines at once.
  constexpr std::size_t kLine = 64;
  for (std::size_t at = 0; at < sizeof fresh; at += kLine) {
    __builtin_prefetch(reinterpret_cast<const char*>(&fresh) + at, 1);
  }
  if (fresh.whole) travel_ = std::numeric_limits<double>::infinity();
  if (fresh.from != 0) return step_to(fresh);
  const bool strokes_edited = fresh.edits != patch_.edits, edited = strokes_edited || fresh.pieces != patch_.pieces;
  const bool first = patch_.number == 0;
  for (std::size_t i = 0; i < fresh.loose.size(); ++i) removed[i] += fresh.loose[i] - patch_.loose[i];
  glm::ivec3 lo, hi;
  bool filled = false;
  if (!first && edited) {
    repeat_cuts(fresh, removed);
  } else if (!first && log_.since(fresh.cuts, lo, hi, filled)) {
    merge(fresh, patch_, lo, hi, filled);
    update_coarse(fresh, false);
  }
  std::swap(fresh, patch_);
  std::swap(fresh.step, patch_.step);  // the memory for steps stays in `fresh`, which returns to the carver
  adopted(strokes_edited, !edited && !first);
}

/// Moves patch_ to the position of `fresh`, which contains only the new samples. Old samples keep the servo's cuts.
void PatchModel::step_to(TissuePatch& fresh) noexcept {
  if (fresh.from != patch_.number) return;  // cannot happen: `fresh` is always made for the snapshot in use
  const glm::ivec3 old_lo = patch_.lo, old_hi = patch_.lo + patch_.n - 1;
  glm::ivec3 lo, hi;
  bool filled = false;
  const bool late = log_.since(fresh.cuts, lo, hi, filled);
  if (late) update_coarse(fresh, false);
  take_step(patch_, fresh);
  if (late) {
    mark_merged(patch_, glm::max(lo, old_lo), glm::min(hi, old_hi), filled);
    // A cut across the old border of the tissue patch must also change the new samples, so it is repeated.
    for (std::uint64_t i = log_.first_after(patch_.cuts); i <= log_.last(); ++i) {
      if (!log_.is_inside(i, old_lo, old_hi)) repeat(log_.made(i), i, patch_);
    }
  }
  adopted(false, true);
}

/// Repeats the servo's newest cuts in `fresh`, if it contains an undo, a redo or the removal of a loose piece that the
/// old patch lacks. Volume that both a loose piece and a cut remove is counted once.
void PatchModel::repeat_cuts(TissuePatch& fresh, PerTissue& all_removed) noexcept {
  const double h = voxel();
  for (std::uint64_t i = log_.first_after(fresh.cuts); i <= log_.last(); ++i) {
    CutLog::Made& made = log_.made(i);
    // After an undo, a repeated cut removes more volume than at first; after the removal of a loose piece, less.
    const PerTissue removed = repeat(made, i, fresh);
    for (std::size_t t = 0; t < removed.size(); ++t) all_removed[t] += (removed[t] - made.removed[t]) * h * h * h;
    made.removed = removed;
  }
  for (std::size_t i = 0; i < all_removed.size(); ++i) all_removed[i] -= fresh.taken_back[i] - patch_.taken_back[i];
  update_coarse(fresh, true);
}

Tissue PatchModel::tissue_at(const dvec3& p_W) const noexcept {
  const dvec3 p_V = settings_.frame.to_voxels(p_W);
  return patch_.holds(p_V, 0) ? haptics::tissue_at(patch_, p_V) : Tissue::kAir;
}

}  // namespace typodont::haptics
