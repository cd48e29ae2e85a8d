// Passivity: the force is limited so that the hand never receives energy that it did not supply.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// A passivity observer (Hannaford & Ryu 2002) knows the energy F·Δx one tick late. So here, the energy ledger must
/// hold the next tick's energy in advance. For this, the hand's motion out of the tissue (retreat) is predicted.
struct PassivityLaw {
  // The predicted retreat is at least this × the fastest recent retreat: a tick may be missed, or the hand gets faster.
  double margin = 2.5;
  double memory = 0.05;  // s, time constant with which the fastest recent retreat decays
  // m/s², largest acceleration expected of any hand. If a hand moves inward faster than `turning` × tick period, it
  // cannot reverse its motion within the next tick.
  double turning = 2;
  // s; in a tick longer than 2.2 × this, any hand can (by assumption) reverse, and retreat as fast as it advanced
  double human_tick = 1e-3;
  // m per tick; a larger motion of the hand counts as a jump, whose direction may reverse in the next tick
  double jump_distance = 0.3e-3;
  double twisting = 20;  // rad/s², largest expected angular acceleration of any hand
  // true: positions are multiples of an encoder step, too coarse to show changes of the velocity
  bool in_counts = false;
  // upper limit of the predicted speed of retreat divided by the largest recent speed of the hand
  double faster = 1.2;
  // If the hand may reverse: predicted change of its velocity in the next tick divided by the largest recent change.
  double again = 3;
  // If the hand does not reverse, the predicted change of its velocity in the next tick is: largest recent change +
  // change_margin × max(0, mean change − start_fraction × largest recent change).
  double change_margin = 0.6;
  /// This fraction of the largest recent change of velocity is subtracted from the mean change (see change_margin), so
  /// that a single stroke, with changes only at its start and end, adds nothing.
  double start_fraction = 0.1;
  double mean_weight = 0.01;  // weight of one tick in the running mean of the changes of velocity
  // s; the largest recent speed and change of velocity begin to decay after this time of motion
  double hold = 1;
  // s; replaces `hold` for the largest speed while the hand feels no force. It is shorter, because a fast approach is
  // often followed by a slow touch.
  double free_hold = 0.15;
  double fading = 0.5;  // s, time constant with which the largest recent speed and change of velocity decay
  double uneven = 1.5;  // predicted length of the next tick divided by the longest recent tick, for an irregular clock
  double still = 1e-4;  // m/s; a slower motion of the hand counts as rounding error or rest
  double leap = 2;      // m/s; a faster motion of the hand counts as a jump
  // s, time constant with which `longest` decays; long, because a computer that missed a tick will miss one again
  double clock_memory = 10;
  double longest_gap = 5;  // ticks; a longer time between two samples counts as a pause
  // J, allowed energy deficit: half of the promised limit of 1 nJ. The other half covers rounding and sudden reversals.
  double credit = 0.5e-9;
};

/// Maximum of recent values. It is constant for the time `hold` (s), and decays afterwards.
struct RecentMaximum {
  double most = 0, age = 0;
  void see(double x, double dt, double hold, double fade) noexcept {
    // a value near the maximum restarts the time `hold`
    if (x >= 0.8 * most) {
      most = std::max(most, x), age = 0;
    } else if ((age += dt) > hold) {
      most *= fade;
    }
  }
};

struct PassivityState {
  // m per tick, fastest recent motion out of the tissue, or against the previous tick's displacement
  double retreat = 0;
  double advance = 0;   // m per tick, fastest recent motion against the force
  dvec3 moved{0};       // m, displacement in the previous tick
  double distance = 0;  // m, length of the displacement in the previous tick
  // In a tick of decay_for s, `retreat` decays by the factor decay, `longest` by clock_decay. per_second: 1 / decay_for
  double decay_for = 0, per_second = 0, decay = 1, clock_decay = 1;
  // m/s: largest recent speed, and largest recent change of velocity in one tick; also without contact
  RecentMaximum speed, change;
  double mean_change = 0;       // m/s, mean change of velocity per tick over about 100 moving ticks
  dvec3 heading{0};             // m, displacement in the last tick with motion
  double fade = 1;              // factor per tick by which `speed` and `change` decay
  double since_reversal = 1e9;  // s of motion since the hand's last large reversal
  double longest = 0;           // s, longest recent tick
  // rad per tick, fastest recent rotation along the torque (retreat) and against it (advance); turned: last rotation
  double rotation_retreat = 0, rotation_advance = 0;
  dvec3 turned{0};
};

/// Rotation vector from `from` to `to` in frame W, rad.
inline dvec3 rotation_vector(const dquat& from, const dquat& to) noexcept {
  const dquat q = to * glm::conjugate(from);
  const dvec3 v(q.x, q.y, q.z);
  const double sine = glm::length(v);
  if (!(sine > 0)) return dvec3(0);
  const double angle = 2 * std::atan2(sine, std::abs(q.w));
  return v * ((q.w < 0 ? -angle : angle) / sine);
}

/// Updates the state with a tick of a hand that moves or has just stopped. `moved`: displacement, m; `distance`: its
/// length; `change`: `moved` minus that of the previous tick.
inline void learn(const PassivityLaw& law, const dvec3& moved, double distance, const dvec3& change, double dt,
                  bool touches, PassivityState& state) noexcept {
  const double speed = distance * state.per_second, changed = glm::length(change) * state.per_second;
  if (speed < law.leap) state.speed.see(speed, dt, touches ? law.hold : law.free_hold, state.fade);
  if (changed < law.leap) {
    state.change.see(changed, dt, law.hold, state.fade);
    state.mean_change += law.mean_weight * (changed - state.mean_change);
  }
  state.since_reversal += dt;
  if (distance == 0) return;
  if (glm::dot(moved, state.heading) < 0 && speed > std::max(0.3 * state.speed.most, law.still))
    state.since_reversal = 0;
  state.heading = moved;
}

/// Probability (0..1) that the hand reverses its motion. 1 after a recent reversal, in jumps, at rest, or with an
/// irregular or slow clock. `uneven_clock`: ticks differ from the nominal length.
inline double reversal_probability(const PassivityLaw& law, double tick, bool uneven_clock,
                                   const PassivityState& state) noexcept {
  const bool rests = glm::dot(state.moved, state.moved) < 0.04 * state.speed.most * tick * state.speed.most * tick;
  if (tick > 2.2 * law.human_tick || uneven_clock || rests) return 1;
  const double turned_lately = (law.hold + law.fading - state.since_reversal) / law.fading;
  const double leaps = 4 * (state.speed.most * tick / law.jump_distance - 0.75);
  return std::clamp(std::max(turned_lately, leaps), 0.0, 1.0);
}

/// Predicts the motion out of tissue in the next tick, m. Assumes that the velocity changes as much as recently, up to
/// about the largest recent speed. `along`: m/s outwards; `twitch`: m, motion that is always expected.
inline double expected_retreat(const PassivityLaw& law, double along, double tick, double twitch,
                               const PassivityState& state) noexcept {
  const bool uneven_clock = state.longest > 1.02 * tick;  // 2 % tolerance for a clock in ns
  const double next = (uneven_clock ? law.uneven : 1) * std::max(state.longest, tick);
  const double at_once = law.again * state.change.most,
               restless = std::max(0.0, state.mean_change - law.start_fraction * state.change.most);
  const double likely = state.change.most + law.change_margin * restless;
  const double turn =
      std::max(twitch, (likely + (at_once - likely) * reversal_probability(law, tick, uneven_clock, state)) * next);
  return std::min(turn + along * next, std::max(twitch, law.faster * state.speed.most * next));
}

/// Updates the state with the last tick's displacement (m), its length, and rotation (rad). `touches`: the hand feels a
/// force.
inline void observe(const PassivityLaw& law, const dvec3& moved, double distance, const dvec3& turned, double dt,
                    double tick, bool touches, PassivityState& state) noexcept {
  dvec3 change = moved - state.moved;
  if (dt != state.decay_for) {
    if (state.decay_for > 0) change = moved - state.moved * (dt / state.decay_for);
    state.decay_for = dt, state.decay = std::exp(-dt / law.memory),
    state.clock_decay = std::exp(-dt / law.clock_memory);
    state.fade = std::exp(-dt / law.fading), state.per_second = 1 / dt;
  }
  const double before = state.distance;
  if (!law.in_counts && (distance > 0 || before > 0)) learn(law, moved, distance, change, dt, touches, state);
  state.retreat *= state.decay;
  if (before > 0) state.retreat = std::max(state.retreat, -glm::dot(moved, state.moved) / before);
  state.moved = moved, state.distance = distance;
  state.rotation_retreat *= state.decay;
  if (state.turned != dvec3(0)) {  // usually there is no rotation
    state.rotation_retreat =
        std::max(state.rotation_retreat, -glm::dot(turned, state.turned) / glm::length(state.turned));
  }
  state.turned = turned;
  if (dt != tick || state.longest != tick) {
    state.longest = tick + (state.longest - tick) * state.clock_decay;
    if (dt < law.longest_gap * tick) state.longest = std::max(state.longest, dt);
  }
}

/// Energy in J that the force `f` (N) and torque `tau` (N·m) may give to the hand in the next tick.
/// `moved`, `turned`: m and rad in the last tick. Updates the state.
inline double energy_at_stake(const PassivityLaw& law, const dvec3& f, const dvec3& moved, const dvec3& tau,
                              const dvec3& turned, double dt, double tick, PassivityState& state) noexcept {
  const double strength = glm::length(f), twist = glm::length(tau);
  observe(law, moved, glm::length(moved), turned, dt, tick, strength > 0, state);
  double at_stake = 0;
  if (strength > 0) {
    // m, displacement of the hand along the force; positive: outwards
    const double along = glm::dot(f, moved) / strength;
    state.retreat = std::max(state.retreat, along);
    state.advance = std::max(state.advance * state.decay, -along);
    const double twitch = law.turning * tick * tick;
    const double back = !law.in_counts ? expected_retreat(law, along / dt, tick, twitch, state)
                                       : twitch + (tick > 2.2 * law.human_tick ? state.advance : along);
    at_stake = strength * std::max({law.margin * state.retreat, back, 1e-3 * twitch});
  }
  if (twist > 0) {  // also without force, because a torque decays more slowly
    // rotation about the torque's axis, rad; positive: along the torque
    const double out = glm::dot(tau, turned) / twist;
    state.rotation_retreat = std::max(state.rotation_retreat, out);
    state.rotation_advance = std::max(state.rotation_advance * state.decay, -out);
    const double twitch = law.twisting * tick * tick;
    const double back = tick > 2.2 * law.human_tick ? twitch + state.rotation_advance : twitch + std::min(out, 0.0);
    at_stake += twist * std::max({law.margin * state.rotation_retreat, back, 1e-3 * twitch});
  }
  return at_stake;
}

/// Largest fraction 0..1 of the force that `energy` (J) and the credit cover. Other arguments: see energy_at_stake().
inline double passive_fraction(const PassivityLaw& law, const dvec3& f, const dvec3& moved, const dvec3& tau,
                               const dvec3& turned, double dt, double tick, double energy,
                               PassivityState& state) noexcept {
  const double at_stake = energy_at_stake(law, f, moved, tau, turned, dt, tick, state);
  return at_stake > 0 ? std::clamp((energy + law.credit) / at_stake, 0.0, 1.0) : 1.0;
}

}  // namespace typodont::haptics
