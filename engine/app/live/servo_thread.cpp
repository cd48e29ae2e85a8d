#include <pthread.h>

#include <atomic>

#include "engine/app/live/session.h"
#include "engine/base/realtime.h"
#include "engine/base/units.h"
#include "haptics/work.h"

namespace typodont {

namespace {

constexpr double kRampOut = 0.02;  // s at the end of a session

/// N/m
PerTissue scaled(const MaterialTable& materials, const PerTissue& share) {
  PerTissue stiffness{};
  for (std::size_t i = 0; i < share.size(); ++i) stiffness[i] = share[i] * materials[i].stiffness;
  return stiffness;
}

/// As HapticDevice::contact means it.
bool in_contact(const ServoTick& tick) {
  constexpr std::uint32_t kUnknown = haptics::kNoPose | bits(Fault::kPatchEdge) | bits(Fault::kDeepPenetration);
  return tick.depth > 0 || (tick.faults & kUnknown) != 0;
}

}  // namespace

void servo_thread(LiveSession& s, haptics::HapticDevice& hand) {
  const RealtimeGranted granted = enter_realtime({.priority = 80, .core = RealtimeRequest::kOwnCore});
  s.loop->granted(granted.fifo, granted.pinned, granted.memory_locked, granted.note);
  ::pthread_setname_np(::pthread_self(), "typodont-servo");
  Wiring& wiring = s.wiring;
  const Nanos period = from_seconds(1 / hand.info().rate);
  haptics::HandSample sample;
  SessionSettings settings;
  PedalLock pedal;
  ServoTick tick;
  Cut cut;
  std::uint64_t ticks = 0;
  while (!wiring.stop.load(std::memory_order_relaxed) && hand.read(sample)) {
    const Nanos woke = now(), cpu = thread_cpu_time();
    const std::int32_t chosen = wiring.chosen_tool.load(std::memory_order_relaxed);
    if (chosen >= 0) sample.tool = static_cast<std::uint32_t>(chosen);
    if (haptics::Snapshot* const fresh = wiring.patch.take(s.servo->snapshot(), tick.cuts, woke)) {
      const PatchUse use{fresh->number, ticks, fresh->cuts, fresh->center_W};
      s.servo->adopt(*fresh);
      if (s.record) wiring.patches_to_recorder.push(use);
    }
    if (ticks == 0) wiring.session_zero = woke - sample.t;
    sample.pedal = pedal.pass(sample.pedal, wiring.held.load(std::memory_order_relaxed));
    if (wiring.settings.fetch()) {
      settings = wiring.settings.front();
      if (!s.record) s.servo->set_stiffness(scaled(s.scene.servo.materials, settings.stiffness));
    }
    sample.pedal *= settings.speed_share;
    sample.faults = hand.faults();
    const bool did_cut = s.servo->tick(sample, tick, cut);
    if (wiring.emergency.load(std::memory_order_relaxed)) break;
    hand.contact(in_contact(tick));
    hand.write(settings.force_share * tick.f_T_W, settings.force_share * tick.tau_T_W);
    const Nanos wrote = now();
    // What the servo was told is in the tick; a replay tells it the same.
    tick.faults |= (hand.faults() & ~haptics::kNoPose) | (wrote - woke > period ? bits(Fault::kOverrun) : 0);
    tick.cpu_time = thread_cpu_time() - cpu;
    if (++ticks == 1) s.first_tick = wrote;
    if (did_cut) {
      if (!wiring.cuts_to_carver.push(cut)) tick.faults |= bits(Fault::kRingFull);
      if (s.record) wiring.cuts_to_recorder.push(cut);
      if (s.debris) wiring.cuts_to_debris.push(cut);
    }
    wiring.tick_to_carver.publish(tick);
    if (s.sound) s.sound->push(tick);  // before it is published: a file is made up to the newest that is
    if (s.draw || s.operated || s.sound) wiring.tick_to_render.publish(tick);
    if (s.record) wiring.ticks_to_recorder.push(tick);
    s.faults |= tick.faults;
    wiring.newest_faults.store(tick.faults, std::memory_order_relaxed);
    s.last = tick;
    s.loop->tick(woke, wrote, hand.safety());
    if (s.operated) wiring.ticks_to_score.push(tick);
  }
  s.loop->publish();
  // The end: the force fades within its ramp, the drill at rest. These ticks belong to no session and are not recorded.
  s.servo->ramp_out();
  const Nanos faded = now() + from_seconds(kRampOut);
  while (!wiring.emergency && now() < faded && hand.read(sample)) {
    sample.pedal = 0;
    sample.tool = s.last.tool;
    sample.faults = hand.faults();
    s.servo->tick(sample, tick, cut);
    hand.contact(in_contact(tick));
    hand.write(settings.force_share * tick.f_T_W, settings.force_share * tick.tau_T_W);
  }
  hand.write(dvec3(0), dvec3(0));
  hand.release();  // nor does an arm go on holding up its own weight
  s.servo_cpu = to_seconds(thread_cpu_time());
  s.queries = haptics::queries_of_this_thread();
  wiring.servo_ended = true;
}

}  // namespace typodont
