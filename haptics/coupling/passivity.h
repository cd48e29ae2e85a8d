// The passivity controller: never gives the hand energy that the hand did not put in first.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// A force held for a tick gives the hand exactly F·Δx, and Δx is known only afterwards: an observer alone (Hannaford &
/// Ryu 2002) sees the loss a tick too late. So the force is bounded beforehand by what the ledger holds over the way
/// the hand may retreat in the next tick, foreseen from how fast it retreated lately, how fast a hand can turn round,
/// and how abruptly this one has changed its pace, in the open, too: a hand that trembles, or moves by counts or along
/// straight strokes, does so again. Most hands go on inward once they have begun to. One that has turned round at full
/// pace, or that comes by leaps, on an uneven clock or seldom, may go back as fast as it ever came.
struct PassivityLaw {
  double margin = 2.5;       // of the fastest retreat lately: a tick may be missed, a retreat may quicken
  double memory = 0.05;      // s
  double turning = 2;        // m/s²: a hand that moves inward faster than turning × tick goes on moving inward …
  double human_tick = 1e-3;  // s, … in ticks this short; in longer ones it may go back as far as it came, …
  double long_way = 0.3e-3;  // m, … and where that is so far in a tick
  double twisting = 20;      // rad/s²: the same of a hand that turns
  bool in_counts =
      false;             // the hand is a device's: its changes of pace are counts, which no hand makes, and say nothing
  double faster = 1.2;   // of the greatest pace lately: faster no hand goes back
  double again = 3;      // of the greatest change of pace lately: by as much may one change that can turn at once, …
  double outdone = 0.6;  // … by once that any other, and by this share of the mean change …
  double lonely = 0.1;   // … beyond this share of the greatest: what one stroke's start or end shows is not outdone
  double in_mean = 0.01;  // what a tick weighs in that mean
  double hold = 1;  // s of motion, so long pace and change are known undiminished (a hand at rest forgets nothing), …
  double hold_free = 0.15;   // s, … paces of a hand that touches nothing: it may fly in fast and come down slowly …
  double fading = 0.5;       // s, … and then fade
  double uneven = 1.5;       // of the longest tick lately, what an uneven clock may miss
  double still = 1e-4;       // m/s: slower than that is rounding, or rest
  double leap = 2;           // m/s: a greater one is no hand's
  double clock_memory = 10;  // s, of the longest tick: a clock that misses some goes on missing them, …
  double most_missed = 5;    // … though what is longer than so many is a pause
  double credit = 0.5e-9;    // J, of the 1 nJ that rounding and a sudden turn may cost
};

/// The greatest of something lately.
struct Lately {
  double most = 0, age = 0;
  void see(double x, double dt, double hold, double fade) noexcept {
    if (x >= 0.8 * most) {  // as much again: it goes on being so
      most = std::max(most, x), age = 0;
    } else if ((age += dt) > hold) {
      most *= fade;
    }
  }
};

struct PassivityState {
  double retreat = 0;  // m in one tick: the longest way back lately, out of the tissue or against its own direction
  double advance = 0;  // m in one tick: the longest way in lately, against the force
  dvec3 moved{0};      // m, the tick before
  double way = 0;      // m, of the tick before
  double decay_for = 0, per_second = 0, decay = 1, clock_decay = 1;  // in a tick as long as the last one
  Lately pace, change;      // m/s, of the hand, in the open, too, and from tick to tick, …
  double mean_change = 0;   // … and its mean in the last hundred ticks of motion
  dvec3 heading{0};         // m, its way when it last moved
  double fade = 1;          // in a tick as long as the last one
  double since_turn = 1e9;  // s of motion since it last turned round at a pace worth the name
  double longest = 0;       // s, the longest tick lately
  // The same of turns, rad.
  double unturn = 0, turn_in = 0;
  dvec3 turned{0};
};

/// The rotation vector, in W, that turns `from` into `to`; rad.
inline dvec3 rotation_vector(const dquat& from, const dquat& to) noexcept {
  const dquat q = to * glm::conjugate(from);
  const dvec3 v(q.x, q.y, q.z);
  const double sine = glm::length(v);
  if (!(sine > 0)) return dvec3(0);
  const double angle = 2 * std::atan2(sine, std::abs(q.w));
  return v * ((q.w < 0 ? -angle : angle) / sine);
}

/// What a hand that moves, or just stopped, shows of how abruptly it does so. `moved`, `change`: m in this tick, and
/// more than in the last; `way`: how long that is.
inline void learn(const PassivityLaw& law, const dvec3& moved, double way, const dvec3& change, double dt, bool touches,
                  PassivityState& state) noexcept {
  const double pace = way * state.per_second, changed = glm::length(change) * state.per_second;
  if (pace < law.leap) state.pace.see(pace, dt, touches ? law.hold : law.hold_free, state.fade);
  if (changed < law.leap) {
    state.change.see(changed, dt, law.hold, state.fade);
    state.mean_change += law.in_mean * (changed - state.mean_change);
  }
  state.since_turn += dt;
  if (way == 0) return;
  if (glm::dot(moved, state.heading) < 0 && pace > std::max(0.3 * state.pace.most, law.still)) state.since_turn = 0;
  state.heading = moved;
}

/// How surely a hand may turn at once, 0..1: it has lately, leaps, comes on an uneven clock or seldom, or rests.
/// `uneven_clock`: ticks of another length than asked for.
inline double abruptness(const PassivityLaw& law, double tick, bool uneven_clock,
                         const PassivityState& state) noexcept {
  const bool rests = glm::dot(state.moved, state.moved) < 0.04 * state.pace.most * tick * state.pace.most * tick;
  if (tick > 2.2 * law.human_tick || uneven_clock || rests) return 1;
  const double turned_lately = (law.hold + law.fading - state.since_turn) / law.fading;
  const double leaps = 4 * (state.pace.most * tick / law.long_way - 0.75);
  return std::clamp(std::max(turned_lately, leaps), 0.0, 1.0);
}

/// How far the hand may go outward in the next tick, m: it changes its pace as it lately did, or by more if it can turn
/// at once, but goes hardly faster than it lately went. `along`: m/s, outward; `twitch`: m that any hand may go.
inline double way_back(const PassivityLaw& law, double along, double tick, double twitch,
                       const PassivityState& state) noexcept {
  const bool uneven_clock = state.longest > 1.02 * tick;  // more than a clock in nanoseconds rounds
  const double next = (uneven_clock ? law.uneven : 1) * std::max(state.longest, tick);
  const double at_once = law.again * state.change.most,
               restless = std::max(0.0, state.mean_change - law.lonely * state.change.most);
  const double likely = state.change.most + law.outdone * restless;
  const double turn =
      std::max(twitch, (likely + (at_once - likely) * abruptness(law, tick, uneven_clock, state)) * next);
  return std::min(turn + along * next, std::max(twitch, law.faster * state.pace.most * next));
}

/// The share, 0..1, of force `f` and torque `tau` (N, N·m, on the hand) that may be given. `moved`, `turned`: the
/// hand's way in the last tick, m, rad; `energy`: what the ledger holds, J.
inline double passive_share(const PassivityLaw& law, const dvec3& f, const dvec3& moved, const dvec3& tau,
                            const dvec3& turned, double dt, double tick, double energy,
                            PassivityState& state) noexcept {
  dvec3 change = moved - state.moved;
  if (dt != state.decay_for) {
    if (state.decay_for > 0) change = moved - state.moved * (dt / state.decay_for);
    state.decay_for = dt, state.decay = std::exp(-dt / law.memory),
    state.clock_decay = std::exp(-dt / law.clock_memory);
    state.fade = std::exp(-dt / law.fading), state.per_second = 1 / dt;
  }
  const double strength = glm::length(f), twist = glm::length(tau);
  const double way = glm::length(moved), before = state.way;
  if (!law.in_counts && (way > 0 || before > 0)) learn(law, moved, way, change, dt, strength > 0, state);
  state.retreat *= state.decay;
  if (before > 0) state.retreat = std::max(state.retreat, -glm::dot(moved, state.moved) / before);
  state.moved = moved, state.way = way;
  state.unturn *= state.decay;
  if (state.turned != dvec3(0)) {  // most hands only move
    state.unturn = std::max(state.unturn, -glm::dot(turned, state.turned) / glm::length(state.turned));
  }
  state.turned = turned;
  if (dt != tick || state.longest != tick) {
    state.longest = tick + (state.longest - tick) * state.clock_decay;
    if (dt < law.most_missed * tick) state.longest = std::max(state.longest, dt);
  }
  if (!(strength > 0 || twist > 0)) return 1;
  double at_stake = 0;
  if (strength > 0) {
    const double along = glm::dot(f, moved) / strength;  // > 0: with the force, outward
    state.retreat = std::max(state.retreat, along);
    state.advance = std::max(state.advance * std::exp(-dt / law.memory), -along);
    const double twitch = law.turning * tick * tick;
    const double back = !law.in_counts ? way_back(law, along / dt, tick, twitch, state)
                                       : twitch + (tick > 2.2 * law.human_tick ? state.advance : along);
    at_stake = strength * std::max({law.margin * state.retreat, back, 1e-3 * twitch});
  }
  if (twist > 0) {                                     // of a tool whose force has gone, too: its torque follows later
    const double out = glm::dot(tau, turned) / twist;  // > 0: with the torque
    state.unturn = std::max(state.unturn, out);
    state.turn_in = std::max(state.turn_in * std::exp(-dt / law.memory), -out);
    const double twitch = law.twisting * tick * tick;
    const double back = tick > 2.2 * law.human_tick ? twitch + state.turn_in : twitch + std::min(out, 0.0);
    at_stake += twist * std::max({law.margin * state.unturn, back, 1e-3 * twitch});
  }
  return std::clamp((energy + law.credit) / at_stake, 0.0, 1.0);
}

}  // namespace typodont::haptics
