#include <pthread.h>

#include <atomic>

#include "engine/app/live/session.h"
#include "engine/base/realtime.h"
#include "engine/base/units.h"
#include "haptics/device_safety.h"
#include "haptics/soft_tissue.h"
#include "haptics/work.h"

namespace typodont {

namespace {

constexpr double kRampOut = 0.02;  // s, duration of the force ramp at the session's end
// Faults on which Servo::tick depends. All other faults are only results of a tick.
constexpr std::uint32_t kServoInputFaults = haptics::kNoPose | bits(Fault::kLetGo) | bits(Fault::kHeld);

/// True if the tool touches tissue or is inside it, or if the contact is unknown.
bool in_contact(const ServoTick& tick) {
  constexpr std::uint32_t kUnknown = haptics::kNoPose | bits(Fault::kPatchEdge) | bits(Fault::kDeepPenetration);
  return tick.depth > 0 || (tick.faults & kUnknown) != 0;
}

}  // namespace

ServoTurns::ServoTurns(LiveSession& s, haptics::HapticDevice& hand, Nanos (*clock)() noexcept)
    : s_(s),
      hand_(hand),
      clock_(clock),
      period_(from_seconds(1 / hand.info().rate)),
      side_(*s.servo, s.wiring.event_logs.servo, hand.info().rate) {}

bool ServoTurns::turn() noexcept {
  LiveSession& s = s_;
  Wiring& wiring = s.wiring;
  haptics::HapticDevice& hand = hand_;
  if (wiring.stop.load(std::memory_order_relaxed) || !hand.read(sample_)) return false;
  const Nanos woke = clock_(), cpu = thread_cpu_time();
  const std::int32_t chosen = wiring.chosen_tool.load(std::memory_order_relaxed);
  if (chosen >= 0) sample_.tool = static_cast<std::uint32_t>(chosen);
  side_.take_patch(wiring.patch, woke);
  if (ticks_ == 0) wiring.session_zero = woke - sample_.t;
  const bool held = haptics::emergency_stopped();
  sample_.pedal = pedal_.pass(sample_.pedal, held);
  if (wiring.settings.fetch()) {
    settings_ = wiring.settings.front();
    if (!s.record) s.servo->set_stiffness(settings_.stiffness_of(s.scene.servo.materials));
  }
  sample_.pedal *= settings_.backwards ? -settings_.speed_fraction : settings_.speed_fraction;
  sample_.faults = hand.faults() | (held ? bits(Fault::kHeld) : 0);
  const bool did_cut = s.servo->tick(sample_, tick_, cut_);
  if (wiring.emergency.load(std::memory_order_relaxed)) return false;
  hand.contact(in_contact(tick_));
  send();
  const Nanos wrote = clock_();
  // The hand's faults may have changed during this tick. For the faults in kServoInputFaults, the tick stores the
  // values that the servo used, so that a replay can repeat them; for the other faults, the current values.
  tick_.faults |= (sample_.faults & kServoInputFaults) | (hand.faults() & ~kServoInputFaults);
  hand.see(tick_);
  if (wrote - woke > period_) tick_.faults |= bits(Fault::kOverrun);
  tick_.cpu_time = thread_cpu_time() - cpu;
  if (++ticks_ == 1) s.first_tick = wrote;
  side_.write(tick_, did_cut ? &cut_ : nullptr);
  s.faults |= tick_.faults;
  s.last = tick_;
  s.loop->tick(woke, wrote, hand.safety());
  return true;
}

void ServoTurns::send() noexcept {
  haptics::ForceDelay::Wrench wrench{tick_.f_T_W, tick_.tau_T_W};
  if (s_.delay) wrench = s_.delay->pass(tick_, settings_.force_delay);
  hand_.write(settings_.force_fraction * wrench.f_T_W, settings_.force_fraction * wrench.tau_T_W);
}

void ServoTurns::end() noexcept {
  LiveSession& s = s_;
  Wiring& wiring = s.wiring;
  s.loop->publish();
  // At the end, the force ramps down with the drill off. These ticks are not part of the session, so they are not
  // recorded.
  s.servo->ramp_out();
  const Nanos faded = clock_() + from_seconds(kRampOut);
  while (!wiring.emergency && clock_() < faded && hand_.read(sample_)) {
    sample_.pedal = 0;
    sample_.tool = s.last.tool;
    sample_.faults = hand_.faults();
    s.servo->tick(sample_, tick_, cut_);
    hand_.contact(in_contact(tick_));
    send();
  }
  hand_.write(dvec3(0), dvec3(0));
  hand_.release();  // this also ends the gravity compensation of an arm
}

void servo_thread(LiveSession& s, haptics::HapticDevice& hand) {
  const RealtimeGranted granted = enter_realtime({.priority = 80, .core = RealtimeRequest::kOwnCore});
  s.loop->granted(granted.fifo, granted.pinned, granted.memory_locked, granted.note);
  ::pthread_setname_np(::pthread_self(), "typodont-servo");
  use_ieee_arithmetic();
  ServoTurns turns(s, hand);
  while (turns.turn()) {
  }
  turns.end();
  s.servo_cpu = to_seconds(thread_cpu_time());
  s.queries = haptics::queries_of_this_thread();
  s.looks = haptics::looks_of_this_thread();
  s.wiring.servo_ended = true;
}

}  // namespace typodont
