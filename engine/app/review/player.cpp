#include "engine/app/review/player.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/app/recording/replay.h"
#include "engine/app/recording/resume.h"
#include "engine/base/error.h"

namespace typodont {

namespace {

constexpr double kSlowestPlay = 0.125, kFastestPlay = 16;

}  // namespace

SessionPlayer::SessionPlayer(const session::OpenedSession& session)
    : session_(session),
      scene_(scene_of(session_)),
      tissue_(session_, scene_, load_tissue(scene_)),
      source_(session_, scene_),
      world_(scene_, source_.gum()) {
  if (session_.tick_count() == 0) throw Error(session.file().string(), "", "no ticks", "a recorded session");
  begin_ = to_seconds(session_.ticks(0, 1).front().t);
  end_ = to_seconds(session_.ticks(session_.tick_count() - 1, 1).front().t);
  if (scene_.needs("debris")) world_.add_debris(tissue());
  world_.add_warnings(tissue(), session_.header().warnings);
  seek(begin_);
}

void SessionPlayer::add_heat() {
  if (!scene_.heat || world_.heat()) return;
  world_.add_heat(load_tissue(scene_), session_.header().servo_rate);
  const double at = to_seconds(world_.tick().t);
  world_.restart(/*debris=*/!backwards_);
  source_.rewind();
  seek(at, backwards_);
}

void SessionPlayer::smooth_to(float tolerance) {
  tolerance_ = tolerance;
  view_.reset();
}

std::vector<render::MeshUpdate> SessionPlayer::take_surface() {
  const bool anew = std::exchange(meshed_, tissue_.restarts()) != tissue_.restarts();
  if (!view_ || anew) view_.emplace(tolerance_, scene_.drawn_as);
  std::vector<render::MeshUpdate> surface = view_->update(tissue_.carver());
  // After a restart with the initial tissue, all bricks of the mesh are sent again, and bricks that no longer exist are
  // removed.
  std::set<std::uint64_t> gone;
  if (anew) gone.swap(shown_);
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

void SessionPlayer::seek(double seconds, bool backwards) {
  const Nanos t = from_seconds(std::clamp(seconds, begin_, end_));
  tissue_.seek(t);
  if (t < world_.tick().t || backwards != backwards_) {
    backwards_ = backwards;
    world_.restart(/*debris=*/!backwards);
    source_.rewind();
  }
  while (source_.advance(t)) reader_.read();
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
  speed = sign * std::clamp(std::abs(speed) * (up ? 2 : 0.5), kSlowestPlay, kFastestPlay);
}

}  // namespace typodont
