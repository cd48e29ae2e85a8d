#include "engine/app/stepped.h"

#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/clock.h"

namespace typodont {

namespace {

haptics::LockStep lock_step_for(const Scene& scene, haptics::TissueVolume tissue, const haptics::DeviceInfo& hand) {
  const haptics::ServoSettings settings =
      servo_settings(scene, tissue, hand.rate, hand.vibration_band, hand.position_step, hand.torque_limit > 0);
  return haptics::LockStep(std::move(tissue), settings);
}

haptics::DeviceInfo ideal_hand(double rate) {
  haptics::DeviceInfo hand;
  hand.rate = rate;
  hand.torque_limit = 1e9;
  return hand;
}

}  // namespace

SteppedSession::SteppedSession(const Scene& scene, haptics::TissueVolume tissue, const haptics::DeviceInfo& hand)
    : steps_(lock_step_for(scene, std::move(tissue), hand)), rate_(hand.rate) {}

SteppedSession::SteppedSession(const Scene& scene, haptics::TissueVolume tissue, double rate)
    : SteppedSession(scene, std::move(tissue), ideal_hand(rate)) {}

EventLogs& SteppedSession::event_logs() {
  if (!event_logs_) {
    event_logs_ = std::make_unique<EventLogs>();
    side_.emplace(servo(), event_logs_->servo, rate_);
  }
  return *event_logs_;
}

const ServoTick& SteppedSession::tick(const haptics::HandSample& hand) {
  steps_.stall(held_ || (stall_ > 0 && std::fmod(to_seconds(hand.t) + 0.5, 1.0) < stall_));
  did_cut_ = steps_.tick(hand, tick_, cut_);
  if (omits_times_) tick_.cpu_time = 0;
  if (side_) {
    if (const PatchUse* const use = steps_.fresh_snapshot()) side_->write(*use);
    side_->write(tick_, cut());
  }
  write_pieces();
  return tick_;
}

bool SteppedSession::advance(haptics::HapticDevice& hand) {
  haptics::HandSample sample;
  if (!hand.read(sample)) {
    steps_.apply_cuts(std::numeric_limits<std::uint64_t>::max());
    write_pieces();
    return false;
  }
  sample.faults = hand.faults();
  tick(sample);
  hand.write(tick_.f_T_W, tick_.tau_T_W);
  hand.see(tick_);
  return true;
}

void SteppedSession::write_pieces() {
  for (const LoosePiece& piece : carver().take_pieces()) {
    ++pieces_;
    if (event_logs_) event_logs_->carver.write(piece);
  }
}

}  // namespace typodont
