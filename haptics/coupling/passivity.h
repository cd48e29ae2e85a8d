// The passivity controller: the hand never receives energy that it did not put in before.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// A force that is constant during a tick gives the hand the energy F·Δx, and Δx is known only after the tick. So an
/// observer alone (Hannaford & Ryu 2002) detects a loss one tick too late. This law limits the force in advance: the
/// energy in the energy ledger must suffice for the distance that the hand may retreat in the next tick. This distance
/// is predicted from the recent retreats, from the acceleration that is expected of any hand, and from the recent
/// changes of this hand's velocity, also outside the tissue. (A hand that trembles, moves in encoder counts or makes
/// straight strokes will do so again.)
/// A hand that moves inward is expected to continue inward. But a hand that recently reversed at full speed, moves in
/// jumps, or has a slow or irregular clock is expected to retreat as fast as it ever advanced.
struct PassivityLaw {
  // factor on the fastest recent retreat, because the servo may miss a tick and a retreat may accelerate
  double margin = 2.5;
  double memory = 0.05;  // s, time constant with which earlier retreats are forgotten
  // m/s², expected acceleration of any hand. A hand that moves inward faster than turning × tick length is expected to
  // continue inward.
  double turning = 2;
  // s, longest tick for which `turning` is valid; in a much longer tick, the hand may retreat as fast as it advanced
  double human_tick = 1e-3;
  // m; a hand that moves this far in one tick counts as moving in jumps: it may reverse within one tick
  double jump_distance = 0.3e-3;
  double twisting = 20;  // rad/s², expected angular acceleration of any hand
  // true: positions are encoder counts, so their differences say nothing about changes of the hand's velocity
  bool in_counts = false;
  // factor; the hand is expected to retreat at most this factor times as fast as its greatest recent speed
  double faster = 1.2;
  // Factor. The velocity of a hand that may reverse its motion within one tick is expected to change in a tick by at
  // most this factor times the greatest recent velocity change.
  double again = 3;
  // Factor on the mean velocity change. A hand that is not expected to reverse within one tick is expected to change
  // its velocity by at most its greatest recent change plus this factor times the mean change. (Before this,
  // start_fraction reduces the mean.)
  double change_margin = 0.6;
  /// Fraction of the greatest velocity change that is subtracted from the mean velocity change before change_margin is
  /// applied. At the start or end of a single stroke, the mean is small, so the result is 0.
  double start_fraction = 0.1;
  double mean_weight = 0.01;  // weight of one tick in the mean velocity change
  // s, time in motion during which the greatest speed and velocity change do not decay; time at rest does not count
  double hold = 1;
  // s, time for which the greatest speed does not decay while the hand has no contact; shorter than `hold`, because the
  // hand may approach fast and then touch slowly
  double free_hold = 0.15;
  double fading = 0.5;  // s, time constant with which the greatest speed and change decay after the time `hold`
  double uneven = 1.5;  // if the clock is irregular, the next tick may take this factor × the longest recent tick
  double still = 1e-4;  // m/s; a motion slower than this is rounding or rest
  double leap = 2;      // m/s; a motion faster than this is a jump of the input
  // s, time constant with which the longest tick is forgotten, because a clock that missed ticks will probably miss
  // ticks again
  double clock_memory = 10;
  double longest_gap = 5;  // ticks; a gap longer than this is a pause and does not count as the longest tick
  // J, debt that the energy ledger may have in this law. The guarantee of the controller is a debt of at most 1 nJ; the
  // difference is a reserve for rounding errors and sudden reversals.
  double credit = 0.5e-9;
};

/// Greatest recent value of a quantity. The value does not decay during the time `hold`, then it decays.
struct RecentMaximum {
  double most = 0, age = 0;
  void see(double x, double dt, double hold, double fade) noexcept {
    // a value nearly as large as the maximum restarts the time for which the maximum does not decay
    if (x >= 0.8 * most) {
      most = std::max(most, x), age = 0;
    } else if ((age += dt) > hold) {
      most *= fade;
    }
  }
};

struct PassivityState {
  // m per tick, greatest recent retreat of the hand: its displacement out of the tissue, or opposite to its previous
  // displacement
  double retreat = 0;
  double advance = 0;  // m per tick, greatest recent advance against the force
  dvec3 moved{0};      // m, displacement of the hand in the previous tick
  double way = 0;      // m, length of the displacement `moved` in the previous tick
  // decay_for: s, tick length for which the next three members were computed. per_second: 1/s, reciprocal of the tick
  // length. decay: factor by which the recent retreats decay per tick. clock_decay: factor by which the longest tick
  // decays per tick.
  double decay_for = 0, per_second = 0, decay = 1, clock_decay = 1;
  // m/s; pace: greatest recent speed of the hand; change: greatest recent change of its velocity from one tick to the
  // next. Both are also updated without contact.
  RecentMaximum pace, change;
  double mean_change = 0;       // m/s, mean velocity change over about the last hundred ticks of motion
  dvec3 heading{0};             // m, displacement in the last tick in which the hand moved
  double fade = 1;              // decay factor per tick of the greatest speed (`pace`) and the greatest `change`
  double since_reversal = 1e9;  // s, time in motion since the hand last reversed at a considerable speed
  double longest = 0;           // s, longest recent tick
  // For rotations, rad: greatest recent retreat and advance per tick, and the rotation in the previous tick.
  double rotation_retreat = 0, rotation_advance = 0;
  dvec3 turned{0};
};

/// Returns the rotation vector (rad, workbench frame W) that rotates `from` into `to`.
inline dvec3 rotation_vector(const dquat& from, const dquat& to) noexcept {
  const dquat q = to * glm::conjugate(from);
  const dvec3 v(q.x, q.y, q.z);
  const double sine = glm::length(v);
  if (!(sine > 0)) return dvec3(0);
  const double angle = 2 * std::atan2(sine, std::abs(q.w));
  return v * ((q.w < 0 ? -angle : angle) / sine);
}

/// Updates the recent speed and velocity change of a hand that moves or has just stopped. `moved`: m, displacement in
/// this tick; `change`: m, difference between `moved` and the displacement in the previous tick; `way`: m, length of
/// `moved`.
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

/// Returns the assumed probability, 0..1, that the hand reverses at once. It is 1 if the hand reversed recently, moves
/// in jumps, rests, or has an irregular or slow clock. `uneven_clock`: ticks differ from the nominal length.
inline double reversal_probability(const PassivityLaw& law, double tick, bool uneven_clock,
                                   const PassivityState& state) noexcept {
  const bool rests = glm::dot(state.moved, state.moved) < 0.04 * state.pace.most * tick * state.pace.most * tick;
  if (tick > 2.2 * law.human_tick || uneven_clock || rests) return 1;
  const double turned_lately = (law.hold + law.fading - state.since_reversal) / law.fading;
  const double leaps = 4 * (state.pace.most * tick / law.jump_distance - 0.75);
  return std::clamp(std::max(turned_lately, leaps), 0.0, 1.0);
}

/// Returns the largest displacement (m) of the hand out of the tissue that is expected in the next tick. It is the
/// smaller of two estimates. (1) The hand's velocity changes by at most its largest recent change, or by more if the
/// hand may reverse its motion in one tick. (2) The hand moves only a little faster than its largest recent speed.
/// `along`: m/s, velocity out of the tissue; `twitch`: m, displacement that is expected of any hand, even of a hand at
/// rest.
inline double expected_retreat(const PassivityLaw& law, double along, double tick, double twitch,
                               const PassivityState& state) noexcept {
  const bool uneven_clock = state.longest > 1.02 * tick;  // tolerance of 2 % for the rounding of a clock in ns
  const double next = (uneven_clock ? law.uneven : 1) * std::max(state.longest, tick);
  const double at_once = law.again * state.change.most,
               restless = std::max(0.0, state.mean_change - law.start_fraction * state.change.most);
  const double likely = state.change.most + law.change_margin * restless;
  const double turn =
      std::max(twitch, (likely + (at_once - likely) * reversal_probability(law, tick, uneven_clock, state)) * next);
  return std::min(turn + along * next, std::max(twitch, law.faster * state.pace.most * next));
}

/// Updates the state by the hand's motion in the last tick. `moved`, `turned`: displacement (m) and rotation (rad) of
/// the hand; `way`: m, length of `moved`; `touches`: the hand feels a force.
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
  if (state.turned != dvec3(0)) {  // skipped for a hand that does not rotate, the common case
    state.rotation_retreat =
        std::max(state.rotation_retreat, -glm::dot(turned, state.turned) / glm::length(state.turned));
  }
  state.turned = turned;
  if (dt != tick || state.longest != tick) {
    state.longest = tick + (state.longest - tick) * state.clock_decay;
    if (dt < law.longest_gap * tick) state.longest = std::max(state.longest, dt);
  }
}

/// Returns the largest energy, J, that force `f` and torque `tau` (N, N·m, on the hand) are expected to give the hand
/// in the next tick; 0 without force and torque. `moved`, `turned`: displacement (m) and rotation (rad) of the hand in
/// the last tick. Updates the state.
inline double energy_at_stake(const PassivityLaw& law, const dvec3& f, const dvec3& moved, const dvec3& tau,
                              const dvec3& turned, double dt, double tick, PassivityState& state) noexcept {
  const double strength = glm::length(f), twist = glm::length(tau);
  observe(law, moved, glm::length(moved), turned, dt, tick, strength > 0, state);
  double at_stake = 0;
  if (strength > 0) {
    // m, displacement along the force; positive: in the direction of the force, out of the tissue
    const double along = glm::dot(f, moved) / strength;
    state.retreat = std::max(state.retreat, along);
    state.advance = std::max(state.advance * state.decay, -along);
    const double twitch = law.turning * tick * tick;
    const double back = !law.in_counts ? expected_retreat(law, along / dt, tick, twitch, state)
                                       : twitch + (tick > 2.2 * law.human_tick ? state.advance : along);
    at_stake = strength * std::max({law.margin * state.retreat, back, 1e-3 * twitch});
  }
  if (twist > 0) {  // also computed if the force is already zero, because the torque decays more slowly than the force
    // rad, rotation about the torque's axis; positive: in the direction of the torque
    const double out = glm::dot(tau, turned) / twist;
    state.rotation_retreat = std::max(state.rotation_retreat, out);
    state.rotation_advance = std::max(state.rotation_advance * state.decay, -out);
    const double twitch = law.twisting * tick * tick;
    const double back = tick > 2.2 * law.human_tick ? twitch + state.rotation_advance : twitch + std::min(out, 0.0);
    at_stake += twist * std::max({law.margin * state.rotation_retreat, back, 1e-3 * twitch});
  }
  return at_stake;
}

/// Returns the fraction, 0..1, of force and torque that the energy ledger can pay for. `energy`: J in the ledger; the
/// other arguments are those of energy_at_stake().
inline double passive_fraction(const PassivityLaw& law, const dvec3& f, const dvec3& moved, const dvec3& tau,
                               const dvec3& turned, double dt, double tick, double energy,
                               PassivityState& state) noexcept {
  const double at_stake = energy_at_stake(law, f, moved, tau, turned, dt, tick, state);
  return at_stake > 0 ? std::clamp((energy + law.credit) / at_stake, 0.0, 1.0) : 1.0;
}

}  // namespace typodont::haptics
