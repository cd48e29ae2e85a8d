#include "engine/app/review/recorded_world.h"

#include <cmath>
#include <string_view>

#include "engine/app/session_recorder.h"
#include "engine/app/surroundings/soft_gum.h"

namespace typodont {

namespace {

// N/m, stiffness of the tool in a replay. The recorded poses of the tool already contain its displacement by the gum.
// With this large stiffness, the gum does not displace the tool a second time.
constexpr double kRigid = 1e6;
constexpr std::uint64_t kBlock = 4096;  // number of ticks that are read from the file at a time

const session::StreamData* stream(const session::SessionReader& session, std::string_view name) {
  const auto& specs = session.header().streams;
  for (std::size_t i = 0; i < specs.size(); ++i)
    if (specs[i].name == name) return &session.streams()[i];
  return nullptr;
}

}  // namespace

RecordedWorld::RecordedWorld(const session::SessionReader& session, const Scene& scene,
                             const haptics::TissueVolume& tissue)
    : session_(session),
      surface_(soft_gum(scene.surroundings)),
      world_(scene, surface_),
      water_(stream(session, "water")),
      left_hand_(stream(session, "left_hand")) {
  if (scene.needs("debris")) world_.add_debris(tissue);
  for (const session::SessionEvent& event : session.events())
    if (const auto piece = piece_of(event)) pieces_.push_back(*piece);
  if (surface_) world_.follow_gum([this](SoftGumView& view) { view.take(*gum_); });
  start();
}

void RecordedWorld::start() {
  next_tick_ = 0;
  next_cut_ = next_piece_ = next_water_ = next_hand_ = 0;
  if (surface_) gum_.emplace(surface_, world_.tools(), kRigid);
}

void RecordedWorld::go(Nanos t, bool backwards) {
  if (t < world_.tick().t || backwards != backwards_) {
    backwards_ = backwards;
    world_.restart(/*debris=*/!backwards);
    start();
  }
  for (; next_tick_ < session_.tick_count(); ++next_tick_) {
    if (next_tick_ < block_first_ || next_tick_ >= block_first_ + block_.size()) {
      block_ = session_.ticks(next_tick_, kBlock);
      block_first_ = next_tick_;
    }
    const ServoTick& tick = block_[next_tick_ - block_first_];
    if (tick.t > t && next_tick_ > 0) break;
    apply_events(tick.t);
    if (gum_) press(tick);
    world_.apply(tick);
  }
}

/// Applies all events before the tick at the time t.
void RecordedWorld::apply_events(Nanos t) {
  const auto cuts = session_.cuts();
  for (; next_cut_ < cuts.size() && cuts[next_cut_].t <= t; ++next_cut_) world_.apply(cuts[next_cut_]);
  for (; next_piece_ < pieces_.size() && pieces_[next_piece_].t <= t; ++next_piece_) world_.apply(pieces_[next_piece_]);
  for (; water_ && next_water_ < water_->t.size() && water_->t[next_water_] <= t; ++next_water_) {
    const auto& c = water_->columns;
    world_.apply(WaterSwitch{water_->t[next_water_], c[0][next_water_] != 0, c[1][next_water_] != 0});
  }
  for (; left_hand_ && next_hand_ < left_hand_->t.size() && left_hand_->t[next_hand_] <= t; ++next_hand_) {
    const auto& c = left_hand_->columns;
    const std::size_t i = next_hand_;
    haptics::HandSample sample;
    sample.X_WT = {{c[0][i], c[1][i], c[2][i]}, glm::normalize(dquat(c[3][i], c[4][i], c[5][i], c[6][i]))};
    world_.apply(sample);
  }
}

void RecordedWorld::press(const ServoTick& tick) {
  const auto tools = world_.tools();
  if (tick.tool >= tools.size() || !is_finite(tick.X_WG.p) || gum_->at_rest(tick.X_WG, tick.tool)) return;
  const haptics::Tool& tool = tools[tick.tool];
  const double cutting = tool.turns() ? tool.cutting_coefficient * std::abs(tick.spindle) * tool.radius() : 0.0;
  gum_->tick({tick.t, 1 / session_.header().servo_rate, tick.X_WG, tick.tool, cutting});
}

}  // namespace typodont
