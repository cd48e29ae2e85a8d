// The hand never receives energy that it did not put in.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// A constant force gives F·Δx, known only after the tick, so an observer (Hannaford & Ryu 2002) is a tick late. Here
/// the ledger must cover the next tick's retreat, predicted from recent retreats, any hand's acceleration, and this
/// hand's recent velocity changes, also in air: who trembles, moves in counts or strokes straight will again. Moving
/// inward continues; after a reversal at full speed, in jumps, or with a slow or irregular clock, retreat is as fast as
/// any advance.
struct PassivityLaw {
  // on the fastest retreat: a tick may be missed, a retreat may accelerate
  double margin = 2.5;
  double memory = 0.05;  // s, for forgetting retreats
  // m/s² of any hand. Faster inward than turning × tick continues inward.
  double turning = 2;
  // s, longest tick for `turning`; beyond, retreat as fast as advance
  double human_tick = 1e-3;
  // m per tick, from which motion is in jumps: may reverse at once
  double jump_distance = 0.3e-3;
  double twisting = 20;  // rad/s², expected angular acceleration of any hand
  // encoder counts: differences do not show the velocity's changes
  bool in_counts = false;
  // on the greatest recent speed, for a retreat
  double faster = 1.2;
  // On the greatest recent change, for a hand that may reverse.
  double again = 3;
  // On the mean change, added to the greatest, for one that may not. (start_fraction first reduces the mean.)
  double change_margin = 0.6;
  /// Of the greatest change, off the mean: 0 at the start or end of one stroke.
  double start_fraction = 0.1;
  double mean_weight = 0.01;  // of a tick in the mean
  // s of motion without decay of greatest speed and change
  double hold = 1;
  // s, the same for speed without contact; shorter than `hold`: fast approach, slow touch
  double free_hold = 0.15;
  double fading = 0.5;  // s, decay after `hold`
  double uneven = 1.5;  // next tick / longest recent one, for an irregular clock
  double still = 1e-4;  // m/s; slower is rounding or rest
  double leap = 2;      // m/s; faster is a jump
  // s, for forgetting the longest tick: who missed will miss again
  double clock_memory = 10;
  double longest_gap = 5;  // ticks; longer is a pause
  // J of debt. The guarantee is 1 nJ; the rest is for rounding and sudden reversals.
  double credit = 0.5e-9;
};

/// Constant for `hold`, then decays.
struct RecentMaximum {
  double most = 0, age = 0;
  void see(double x, double dt, double hold, double fade) noexcept {
    // nearly the maximum: `hold` restarts
    if (x >= 0.8 * most) {
      most = std::max(most, x), age = 0;
    } else if ((age += dt) > hold) {
      most *= fade;
    }
  }
};

struct PassivityState {
  // m per tick: out of the tissue, or against the last displacement
  double retreat = 0;
  double advance = 0;  // m per tick, against the force
  dvec3 moved{0};      // m, previous tick
  double way = 0;      // m, length of `moved`
  // s, tick of the next three: 1/s; decay per tick of retreats, and of the longest tick.
  double decay_for = 0, per_second = 0, decay = 1, clock_decay = 1;
  // m/s: greatest speed, and change per tick; also without contact.
  RecentMaximum pace, change;
  double mean_change = 0;       // m/s, over about a hundred moving ticks
  dvec3 heading{0};             // m, in the last tick with motion
  double fade = 1;              // per tick, of `pace` and `change`
  double since_reversal = 1e9;  // s of motion since the last considerable reversal
  double longest = 0;           // s, longest recent tick
  // rad per tick: retreat, advance, previous.
  double rotation_retreat = 0, rotation_advance = 0;
  dvec3 turned{0};
};

/// rad, W, `from` into `to`.
inline dvec3 rotation_vector(const dquat& from, const dquat& to) noexcept {
  const dquat q = to * glm::conjugate(from);
  const dvec3 v(q.x, q.y, q.z);
  const double sine = glm::length(v);
  if (!(sine > 0)) return dvec3(0);
  const double angle = 2 * std::atan2(sine, std::abs(q.w));
  return v * ((q.w < 0 ? -angle : angle) / sine);
}

/// Of a hand that moves or has just stopped. m: displacement, its change, its length.
inline void learn(const PassivityLaw& law, const dvec3& moved, double way, const dvec3& change, double dt, bool touches,
                  PassivityState& state) noexcept {
  const double pace = way * state.per_second, changed = glm::length(change) * state.per_second;
  if (pace < law.leap) state.pace.see(pace, dt, touches ? law.hold : law.free_hold, state.fade);
  if (changed < law.leap) {
    state.change.see(changed, dt, law.hold, state.fade);
    state.mean_change += law.mean_weight * (changed - state.mean_change);
  }
  state.since_reversal += dt;
  if (way == 0) return;
  if (glm::dot(moved, state.heading) < 0 && pace > std::max(0.3 * state.pace.most, law.still)) state.since_reversal = 0;
  state.heading = moved;
}

/// 0..1; 1 after a recent reversal, in jumps, at rest, or with an irregular or slow clock. `uneven_clock`: ticks off
/// the nominal length.
inline double reversal_probability(const PassivityLaw& law, double tick, bool uneven_clock,
                                   const PassivityState& state) noexcept {
  const bool rests = glm::dot(state.moved, state.moved) < 0.04 * state.pace.most * tick * state.pace.most * tick;
  if (tick > 2.2 * law.human_tick || uneven_clock || rests) return 1;
  const double turned_lately = (law.hold + law.fading - state.since_reversal) / law.fading;
  const double leaps = 4 * (state.pace.most * tick / law.jump_distance - 0.75);
  return std::clamp(std::max(turned_lately, leaps), 0.0, 1.0);
}

/// m out of the tissue in the next tick, the smaller of: velocity changed as much as recently (more if it may reverse),
/// and little above the largest speed. `along`: m/s outwards; `twitch`: m, of any hand.
inline double expected_retreat(const PassivityLaw& law, double along, double tick, double twitch,
                               const PassivityState& state) noexcept {
  const bool uneven_clock = state.longest > 1.02 * tick;  // 2 % for a clock in ns
  const double next = (uneven_clock ? law.uneven : 1) * std::max(state.longest, tick);
  const double at_once = law.again * state.change.most,
               restless = std::max(0.0, state.mean_change - law.start_fraction * state.change.most);
  const double likely = state.change.most + law.change_margin * restless;
  const double turn =
      std::max(twitch, (likely + (at_once - likely) * reversal_probability(law, tick, uneven_clock, state)) * next);
  return std::min(turn + along * next, std::max(twitch, law.faster * state.pace.most * next));
}

/// By the last tick. m, rad, and m of length; `touches`: a force is felt.
inline void observe(const PassivityLaw& law, const dvec3& moved, double way, const dvec3& turned, double dt,
                    double tick, bool touches, PassivityState& state) noexcept {
  dvec3 change = moved - state.moved;
  if (dt != state.decay_for) {
    if (state.decay_for > 0) change = moved - state.moved * (dt / state.decay_for);
    state.decay_for = dt, state.decay = std::exp(-dt / law.memory),
    state.clock_decay = std::exp(-dt / law.clock_memory);
    state.fade = std::exp(-dt / law.fading), state.per_second = 1 / dt;
  }
  const double before = state.way;
  if (!law.in_counts && (way > 0 || before > 0)) learn(law, moved, way, change, dt, touches, state);
  state.retreat *= state.decay;
  if (before > 0) state.retreat = std::max(state.retreat, -glm::dot(moved, state.moved) / before);
  state.moved = moved, state.way = way;
  state.rotation_retreat *= state.decay;
  if (state.turned != dvec3(0)) {  // commonly not rotating
    state.rotation_retreat =
        std::max(state.rotation_retreat, -glm::dot(turned, state.turned) / glm::length(state.turned));
  }
  state.turned = turned;
  if (dt != tick || state.longest != tick) {
    state.longest = tick + (state.longest - tick) * state.clock_decay;
    if (dt < law.longest_gap * tick) state.longest = std::max(state.longest, dt);
  }
}

/// J that `f`, `tau` (N, N·m on the hand) may give in the next tick; 0 without. `moved`, `turned`: m, rad, last tick.
/// Updates the state.
inline double energy_at_stake(const PassivityLaw& law, const dvec3& f, const dvec3& moved, const dvec3& tau,
                              const dvec3& turned, double dt, double tick, PassivityState& state) noexcept {
  const double strength = glm::length(f), twist = glm::length(tau);
  observe(law, moved, glm::length(moved), turned, dt, tick, strength > 0, state);
  double at_stake = 0;
  if (strength > 0) {
    // m along the force, positive outwards
    const double along = glm::dot(f, moved) / strength;
    state.retreat = std::max(state.retreat, along);
    state.advance = std::max(state.advance * state.decay, -along);
    const double twitch = law.turning * tick * tick;
    const double back = !law.in_counts ? expected_retreat(law, along / dt, tick, twitch, state)
                                       : twitch + (tick > 2.2 * law.human_tick ? state.advance : along);
    at_stake = strength * std::max({law.margin * state.retreat, back, 1e-3 * twitch});
  }
  if (twist > 0) {  // also without force: torque decays more slowly
    // rad about the torque's axis, positive along it
    const double out = glm::dot(tau, turned) / twist;
    state.rotation_retreat = std::max(state.rotation_retreat, out);
    state.rotation_advance = std::max(state.rotation_advance * state.decay, -out);
    const double twitch = law.twisting * tick * tick;
    const double back = tick > 2.2 * law.human_tick ? twitch + state.rotation_advance : twitch + std::min(out, 0.0);
    at_stake += twist * std::max({law.margin * state.rotation_retreat, back, 1e-3 * twitch});
  }
  return at_stake;
}

/// 0..1 that `energy` (J) covers; the rest as energy_at_stake().
inline double passive_fraction(const PassivityLaw& law, const dvec3& f, const dvec3& moved, const dvec3& tau,
                               const dvec3& turned, double dt, double tick, double energy,
                               PassivityState& state) noexcept {
  const double at_stake = energy_at_stake(law, f, moved, tau, turned, dt, tick, state);
  return at_stake > 0 ? std::clamp((energy + law.credit) / at_stake, 0.0, 1.0) : 1.0;
}

}  // namespace typodont::haptics
