#include "engine/app/haptic_loop.h"

#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/clock.h"

namespace typodont {

haptics::LockStep lock_step_for(const Scene& scene, haptics::TissueVolume tissue, const haptics::DeviceInfo& hand) {
  const haptics::ServoSettings settings =
      servo_settings(scene, tissue, hand.rate, hand.vibration_band, hand.position_step, hand.torque_limit > 0);
  return haptics::LockStep(std::move(tissue), settings);
}

namespace {

haptics::DeviceInfo ideal_hand(double rate) {
  haptics::DeviceInfo hand;
  hand.rate = rate;
  hand.torque_limit = 1e9;
  return hand;
}

}  // namespace

HapticLoop::HapticLoop(const Scene& scene, haptics::TissueVolume tissue, const haptics::DeviceInfo& hand)
    : steps_(lock_step_for(scene, std::move(tissue), hand)) {}

HapticLoop::HapticLoop(const Scene& scene, haptics::TissueVolume tissue, double rate)
    : HapticLoop(scene, std::move(tissue), ideal_hand(rate)) {}

bool HapticLoop::tick(const haptics::HandSample& hand, ServoTick& out, Cut& cut) {
  // Stalls the carver (which updates the tissue) once per second. The first stall begins half a second after the start.
  steps_.stall(held_ || std::fmod(to_seconds(hand.t) + 0.5, 1.0) < stall_);
  return steps_.tick(hand, out, cut);
}

void HapticLoop::run(haptics::HapticDevice& hand, const std::function<void(const ServoTick&, const Cut*)>& each) {
  haptics::HandSample sample;
  ServoTick tick_out;
  Cut cut;
  while (hand.read(sample)) {
    sample.faults = hand.faults();
    const bool did_cut = tick(sample, tick_out, cut);
    hand.write(tick_out.f_T_W, tick_out.tau_T_W);
    hand.see(tick_out);
    each(tick_out, did_cut ? &cut : nullptr);
  }
  steps_.apply_cuts(std::numeric_limits<std::uint64_t>::max());
}

}  // namespace typodont
