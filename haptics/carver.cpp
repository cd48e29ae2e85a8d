#include "haptics/carver.h"

#include <iterator>
#include <memory>
#include <utility>

#include "engine/base/check.h"
#include "haptics/contact/count_method.h"

namespace typodont::haptics {

namespace {

constexpr double kStrokePause = 0.3;  // s, pause after which a cut begins a new stroke

// A snapshot may be centred ahead of a moving tool (TissueBody::leads), by up to 0.8 × travel_, the distance that a
// tool may move from the centre. So a fast tool stays inside the old snapshot for longer, while the next one is made.
constexpr double kLeadTime = 10e-3;    // s, a snapshot is centred at the tool's expected position after this time
constexpr double kLeadFilter = 5e-3;   // s, time constant of the filter for the tool's velocity
constexpr double kLongestGap = 50e-3;  // s, after a longer gap between two ticks, the velocity is unknown

const SharedContactMethod& or_default(const SharedContactMethod& method) {
  return method ? method : default_contact_method();
}

}  // namespace

Carver::Carver(TissueVolume tissue, std::span<const Tool> tools, const SharedContactMethod& method)
    : body_(or_default(method)->make_body(std::move(tissue), tools)),
      tool_count_(tools.size()),
      travel_(body_->travel()) {
  TYPODONT_CHECK(tool_count_ > 0);
  count_method(or_default(method)->name(), 0, 1);
}

Carver::Carver(TissueVolume tissue, const ServoSettings& settings)
    : Carver(std::move(tissue), tool_set(settings), settings.method) {}

bool Carver::begins_stroke(const Cut& cut) const {
  return !in_stroke_ || cut.t < cut_t_ || to_seconds(cut.t - cut_t_) > kStrokePause;
}

void Carver::rest(Nanos t) {
  if (!in_stroke_ || to_seconds(t - cut_t_) <= kStrokePause) return;
  in_stroke_ = false;
  body_->end_stroke();
}

void Carver::end_stroke() {
  in_stroke_ = false;
  body_->end_stroke();
}

void Carver::apply(const Cut& cut) {
  TYPODONT_CHECK(cut.index == cuts_ + 1 && cut.tool < tool_count_);
  if (begins_stroke(cut)) body_->begin_stroke();
  in_stroke_ = true;
  cut_t_ = cut.t;
  if (cut.fill_radius > 0) {
    body_->fill(cut);
  } else {
    // An undo or redo may have restored tissue at the head. The next cut must then also remove tissue inside the head
    // at its start, not only ahead of it.
    const bool edited = edits_ > 0 && cuts_ == edited_at_;
    body_->carve(cut, cuts_ > 0 && !edited && cut.tool == end_tool_ && same(cut.X_WA, end_));
    end_ = cut.X_WB;
    collect_pieces();
  }
  cuts_ = cut.index;
  end_tool_ = cut.tool;
}

void Carver::collect_pieces() {
  for (LoosePiece& piece : body_->take_pieces()) {
    for (std::size_t i = 0; i < loose_volume_.size(); ++i) loose_volume_[i] += piece.removed[i];
    ++piece_count_;
    pieces_.push_back(std::move(piece));
  }
}

std::vector<LoosePiece> Carver::take_pieces() {
  return std::exchange(pieces_, {});
}

bool Carver::undo() {
  end_stroke();
  return edit(body_->undo());
}

bool Carver::redo() {
  return !in_stroke_ && edit(body_->redo());
}

TissueVolume Carver::take_tissue() {
  TissueVolume& left = volume();
  if (TissueSurface* own = surface()) {
    left.set_mesh(std::make_shared<const TissueMesh>(own->mesh()));
  } else if (cuts_ > 0) {
    left.set_mesh(nullptr);  // the source mesh shows the tissue before all cuts, so it is removed
  }
  return std::move(left);
}

bool Carver::edit(bool done) {
  if (!done) return false;
  ++edits_;
  edited_at_ = cuts_;
  return true;
}

/// Estimates the velocity of the proxy, so that the next snapshot can be centred ahead of it.
void Carver::follow(const ServoTick& tick) {
  const double dt = to_seconds(tick.t - seen_t_);
  if (dt == 0) return;
  const dvec3 moved = tick.X_WG.p - seen_p_W_;
  seen_t_ = tick.t, seen_p_W_ = tick.X_WG.p;
  if (dt > 0 && dt < kLongestGap) {
    velocity_W_ += (moved - dt * velocity_W_) / (kLeadFilter + dt);
  } else {
    velocity_W_ = dvec3(0);
  }
}

bool Carver::snapshot_due(const ServoTick& tick) {
  if (body_->leads()) follow(tick);
  if (snapshots_ == 0 || edited()) return true;
  return body_->wants_snapshot(tick.t) || snapshot_due_for(snapshot_center(tick), center_W_, travel_);
}

dvec3 Carver::snapshot_center(const ServoTick& tick) const {
  return snapshot_center_for(tick.X_WG.p, tick.X_WT.p, travel_, kLeadTime * velocity_W_);
}

void Carver::take_snapshot(const dvec3& center_W, Snapshot& snapshot, std::uint32_t number, std::uint32_t held) {
  snapshots_ = number > 0 ? number : snapshots_ + 1;
  snapshot.number = snapshots_;
  snapshot.from = 0;
  snapshot.cuts = cuts_;
  snapshot.edits = edits_in_snapshot_ = edits_;
  snapshot.edited_at = edited_at_;
  snapshot.taken_back = body_->taken_back();
  snapshot.pieces = pieces_in_snapshot_ = piece_count_;
  snapshot.loose = loose_volume_;
  snapshot.center_W = center_W;
  body_->cut_out(snapshot, held);
  center_W_ = snapshot.center_W;
}

bool Carver::bring_up_to_date(Snapshot& snapshot) {
  if (snapshot.number != snapshots_ || edited()) return false;
  body_->bring_up_to_date(snapshot);
  snapshot.cuts = cuts_;
  return true;
}

}  // namespace typodont::haptics
