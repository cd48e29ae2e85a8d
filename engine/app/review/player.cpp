#include "engine/app/review/player.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/app/recording/replay.h"
#include "engine/app/recording/resume.h"
#include "engine/app/session_recorder.h"
#include "engine/base/error.h"

namespace typodont {

namespace {

constexpr std::uint64_t kBlock = 4096;  // number of ticks that are read from the file at a time
constexpr double kSlowest = 0.125, kFastest = 16;

}  // namespace

SessionPlayer::SessionPlayer(const session::OpenedSession& session) : session_(session), scene_(scene_of(session_)) {
  if (session_.tick_count() == 0) throw Error(session.file().string(), "", "no ticks", "a recorded session");
  begin_ = to_seconds(session_.ticks(0, 1).front().t);
  end_ = to_seconds(session_.ticks(session_.tick_count() - 1, 1).front().t);
  const std::vector<StrokeEdit> edits = edits_of(session_);
  auto edit = edits.begin();
  const auto add_edits = [&](std::uint64_t before_cut) {
    for (; edit != edits.end() && edit->cuts < before_cut; ++edit) deeds_.push_back({edit->t, nullptr, edit->redo});
  };
  for (const Cut& cut : session_.cuts()) {
    add_edits(cut.index);
    deeds_.push_back({cut.t, &cut, false});
  }
  add_edits(UINT64_MAX);
  // Two threads recorded these changes, and their clocks may differ. So a time may be smaller than the time before it.
  // Such times are increased; the recorded order of the changes stays.
  for (std::size_t i = 1; i < deeds_.size(); ++i) deeds_[i].t = std::max(deeds_[i].t, deeds_[i - 1].t);
  from_the_start();
  seek(begin_);
}

void SessionPlayer::from_the_start() {
  carver_.emplace(load_tissue(scene_), scene_.servo);
  next_ = 0;
  done_.clear();
  view_.reset();
  anew_ = true;
}

void SessionPlayer::smooth_to(float tolerance) {
  tolerance_ = tolerance;
  view_.reset();
}

std::vector<render::MeshUpdate> SessionPlayer::take_surface() {
  if (!view_) view_.emplace(tolerance_, scene_.drawn_as);
  std::vector<render::MeshUpdate> surface = view_->update(*carver_);
  // If playback restarts with the initial tissue, all bricks (mesh blocks) are sent again, and bricks that no longer
  // exist are removed.
  std::set<std::uint64_t> gone;
  if (std::exchange(anew_, false)) gone.swap(shown_);
  for (const render::MeshUpdate& brick : surface) {
    gone.erase(brick.brick);
    if (brick.indices.empty())
      shown_.erase(brick.brick);
    else
      shown_.insert(brick.brick);
  }
  for (const std::uint64_t brick : gone) surface.emplace_back().brick = brick;
  return surface;
}

void SessionPlayer::go_on(Nanos t) {
  haptics::Carver& carver = *carver_;
  for (; next_ < deeds_.size() && deeds_[next_].t <= t; ++next_) {
    const Deed& deed = deeds_[next_];
    if (deed.cut) {
      // The first cut of the playback may have any number, but the carver (owner of the tissue) expects consecutive
      // numbers. So the carver assigns new numbers.
      Cut cut = *deed.cut;
      cut.index = carver.cuts() + 1;
      if (carver.begins_stroke(cut)) {
        carver.end_stroke();
        const auto before = carver.strokes();
        done_.push_back({Done::Kind::kStroke, next_, before.done + 1, before.undone > 0});
      }
      carver.apply(cut);
    } else if (deed.redo ? carver.redo() : carver.undo()) {
      done_.push_back({deed.redo ? Done::Kind::kRedo : Done::Kind::kUndo, next_, 0, false});
    }
  }
}

void SessionPlayer::go_back(Nanos t) {
  haptics::Carver& carver = *carver_;
  while (next_ > 0 && deeds_[next_ - 1].t > t) {
    if (done_.empty()) return from_the_start();
    const Done last = done_.back();
    if (last.forgets) return from_the_start();
    done_.pop_back();
    next_ = last.first;
    if (last.kind == Done::Kind::kStroke) {
      carver.end_stroke();
      // A stroke that changed nothing was dropped by the carver (owner of the tissue). Then the carver has fewer
      // strokes than `last.strokes`, and there is nothing to undo.
      if (carver.strokes().done == last.strokes) carver.undo();
    } else if (last.kind == Done::Kind::kUndo) {
      carver.redo();
    } else {
      carver.undo();
    }
  }
}

void SessionPlayer::seek(double seconds) {
  const Nanos t = from_seconds(std::clamp(seconds, begin_, end_));
  go_back(t);
  go_on(t);
  if (block_.empty() || block_.front().t > t || block_.back().t <= t)
    block_ = session_.ticks(place_of_tick_at(session_, t), kBlock);
  const auto after =
      std::upper_bound(block_.begin(), block_.end(), t, [](Nanos v, const ServoTick& tick) { return v < tick.t; });
  tick_ = after == block_.begin() ? block_.front() : *(after - 1);
}

void PlayClock::set_range(double a, double b) {
  from = std::clamp(std::min(a, b), begin, end);
  to = std::clamp(std::max(a, b), begin, end);
  at = std::clamp(at, from, to);
}

void PlayClock::advance(double dt) {
  if (paused || over) return;
  const double length = to - from;
  at += speed * dt;
  if (at >= from && at <= to) return;
  if (!loop || !(length > 0)) {
    over = true;
    at = std::clamp(at, from, to);
    return;
  }
  at = from + std::fmod(std::fmod(at - from, length) + length, length);
}

void PlayClock::seek(double t) {
  at = std::clamp(t, from, to);
  over = false;
}

void PlayClock::faster(bool up) {
  const double sign = speed < 0 ? -1 : 1;
  speed = sign * std::clamp(std::abs(speed) * (up ? 2 : 0.5), kSlowest, kFastest);
}

}  // namespace typodont
