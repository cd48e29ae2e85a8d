// Removes tissue from the servo's tissue patch, and repeats cuts that a new patch lacks.
#include <algorithm>
#include <cmath>

#include "haptics/contact/offset/offset_model.h"
#include "haptics/cutting/carve.h"
#include "haptics/fill.h"
#include "haptics/sweep.h"

namespace typodont::haptics::offset {

bool OffsetModel::cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept {
  bool changed = carve_head(in, contact, cut, energy);
  if (tool().fill != Tissue::kAir) changed = fill(in, contact, cut);
  return changed;
}

/// Cuts along the proxy's motion. If tissue changed, returns true and sets `cut`.
bool OffsetModel::carve_head(const ContactInput& in, const Contact& contact, Cut& cut, double& energy) noexcept {
  emptied_ = in.removal.cuts && step_.touching && contacts_.own() > 0 && !step_.deep && !in.removal.must_earn;
  const bool changed = emptied_ && remove_sweep(in, {contact.p_WG, in.X_WT.R}, cut, energy);
  if (!changed) finish_coarse();
  return changed;
}

bool OffsetModel::remove_sweep(const ContactInput& in, const Pose& X_WB, Cut& cut, double& energy) noexcept {
  // Undo or redo may have restored tissue inside the head, so the next cut also removes tissue at its start pose.
  const bool edited = patch_.edits > 0 && cut_count_ == patch_.edited_at;
  const bool continues = cut_count_ > 0 && !edited && cut_tool_ == tool_ && same(in.X_WG, cut_end_);
  const Sweep sweep(tool(), in.X_WG, X_WB, settings_.frame, continues);
  bool changed;
  PerTissue hardened;
  const PerTissue removed = carve(patch_, sweep, &changed, &front_, &hardened);
  if (!changed) return false;
  contacts_.forget_creases();
  ++cut_count_;
  cut.X_WA = in.X_WG, cut.X_WB = X_WB;
  book(removed, hardened, cut, energy);
  cut_end_ = X_WB;
  cut_tool_ = tool_;
  log_.add(cut_count_, sweep.lo(), sweep.hi(), {in.X_WG, X_WB, tool_, continues, 0, removed});
  carve_coarse(in.X_WG, X_WB, continues, sweep.is_long());
  return true;
}

/// Cuts the coarse tissue patch from X_WA to X_WB; joins cuts that are too short for its resolution. `may_wait`: true
/// after a slow fine cut; the coarse cut may then be made in a later tick, because only the shank, which is behind the
/// head, touches the coarse patch.
void OffsetModel::carve_coarse(const Pose& X_WA, const Pose& X_WB, bool continues, bool may_wait) noexcept {
  if (patch_.coarse_levels.empty()) return;
  const bool goes_on = continues && coarse_.cut + 1 >= cut_count_;
  if (!goes_on) {
    finish_coarse();
    coarse_.X_WA = X_WA;
    coarse_.goes_on = false;
  }
  // Upper bound of the motion by rotation: 2.3 √(2 - 2|q·q'|) × reach, with the orientations q and q'.
  const double turned = 2.3 * std::sqrt(std::max(0.0, 2 - 2 * std::abs(glm::dot(X_WB.R, coarse_.X_WA.R))));
  const double moved = glm::length(X_WB.p - coarse_.X_WA.p) + turned * tool().reach();
  coarse_.cut = cut_count_;
  if (goes_on && coarse_.waits == 0 && moved < CoarseParameters::cut_step * coarse_frame().voxel) return;
  coarse_.X_WB = X_WB;
  coarse_.tool = tool_;
  ++coarse_.waits;
  if (!may_wait || coarse_.waits > CoarseParameters::max_waits) finish_coarse();
}

/// Makes the postponed cut of the coarse tissue patch, if there is one.
void OffsetModel::finish_coarse() noexcept {
  if (coarse_.waits == 0) return;
  coarse_.waits = 0;
  const Sweep sweep(heads_[coarse_.tool].tool, coarse_.X_WA, coarse_.X_WB, coarse_frame(), coarse_.goes_on);
  carve(patch_.coarse_levels.front(), sweep, nullptr, &coarse_front_);
  coarse_.X_WA = coarse_.X_WB;
  coarse_.goes_on = true;
}

void OffsetModel::adopted(bool strokes_edited, bool known) noexcept {
  // After undo or redo, the snapshot contains all valid cuts. So a postponed cut of the coarse patch is discarded.
  if (strokes_edited) emptied_ = has_cut_ = false, coarse_.waits = 0;
  if (!known) {
    front_.forget();
    contacts_.forget_creases();
  }
  // The new coarse tissue patch comes from the volume, which was cut in shorter steps, so coarse_front_ is not valid.
  coarse_front_.forget();
  smooth().forget();
}

PerTissue OffsetModel::repeat(const CutLog::Made& made, std::uint64_t index, TissuePatch& fresh) noexcept {
  const Tool& with = heads_[made.tool].tool;
  if (made.fill_radius > 0) {
    bool changed;
    const Fill filling(with, made.X_WA.p, made.fill_radius, made.X_WB, settings_.frame);
    PerTissue added = haptics::fill(fresh, filling, &changed);
    for (double& v : added) v = -v;
    return added;
  }
  const bool continues = made.continues && index != fresh.edited_at + 1;
  return carve(fresh, Sweep(with, made.X_WA, made.X_WB, settings_.frame, continues));
}

/// Adds the servo's cuts that the coarse tissue patch of the new snapshot `fresh` lacks.
void OffsetModel::update_coarse(TissuePatch& fresh, bool edited) noexcept {
  if (fresh.coarse_levels.empty()) return;
  TissuePatch& coarse = fresh.coarse_levels.front();
  const VoxelFrame frame{settings_.frame.origin, voxel() * coarse.every};
  if (edited) {
    for (std::uint64_t i = log_.first_after(fresh.cuts); i <= log_.last(); ++i) {
      const CutLog::Made& made = log_.made(i);
      if (!(made.fill_radius > 0)) carve(coarse, Sweep(heads_[made.tool].tool, made.X_WA, made.X_WB, frame));
    }
    return;
  }
  glm::ivec3 lo, hi;
  bool filled = false;
  if (patch_.coarse_levels.empty() || !log_.since(fresh.cuts, lo, hi, filled) || filled) return;
  const int n = coarse.every, margin = static_cast<int>(Sweep::kMargin) + 1;
  lo = glm::max(lo, glm::ivec3(-1'000'000)) / n - margin;
  hi = glm::min(hi, glm::ivec3(1'000'000)) / n + margin;
  merge(coarse, patch_.coarse_levels.front(), lo, hi);
}

}  // namespace typodont::haptics::offset
