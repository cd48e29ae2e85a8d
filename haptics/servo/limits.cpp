// Limits the force in each tick: limits of the device, ramps at start and end, and the passivity controller with its
// energy ledger. Servo thread only.
#include <algorithm>
#include <cmath>

#include "haptics/servo/state.h"

namespace typodont::haptics {

using P = LimitParameters;

bool Servo::State::lands(const ContactTick& now) noexcept {
  return now.in.cuts && !now.in.scrapes && !now.contact.gives_force;
}

dvec3 Servo::State::force_change(const ContactTick& now) const noexcept {
  return now.force + now.teeth_force - limits.last_force - limits.last_teeth_force;
}

/// Returns by how much (N) a force change must be reduced in this tick; the rest follows in later ticks. `change`: N,
/// size of the change, larger than the slew limit allows. A change that the hand's own displacement causes is
/// excepted: while the hand retreats, it is not delayed; while the hand advances, at most
/// lag_limit of it is delayed. A delayed force is too small while the hand advances and too large while it retreats,
/// and both take energy from the energy ledger.
double Servo::State::held_back(const ContactTick& now, double change) const noexcept {
  const double over = change - P::drilling_slew * now.dt;
  if (!lands(now)) return std::min(over, P::lag_limit);
  const double k = settings.stiffness * coupling.relative_stiffness;
  const double beyond = std::max(0.0, change - P::spring_tolerance * k * glm::length(now.moved));
  if (glm::dot(now.moved, limits.last_force != dvec3(0) ? limits.last_force : now.force) > 0) {
    // The hand retreats. Two limits apply: drilling_slew, and the change that the hand's displacement causes. Only the
    // part of the change above both limits must wait for later ticks.
    return std::min(over, beyond);
  }
  // The hand advances. The force of a tool in an implant bed falls when a drill perforates the bone. Only lag_limit of
  // this change waits, so that the hand feels the breakthrough at once.
  const bool falls =
      glm::length(now.force + now.teeth_force) < glm::length(limits.last_force + limits.last_teeth_force);
  const bool perforates = falls && now.contact.holds_turn;
  return std::min(over, perforates ? P::lag_limit : std::max(P::lag_limit, beyond));
}

void Servo::State::limit(ContactTick& now) noexcept {
  Limits& l = limits;
  now.unlimited = now.force != dvec3(0) ? glm::length(now.force) : 0;
  // A head may fall from a rim or through soft tissue and then meet tissue, for example the bottom of its own cut.
  // Limits the change of its force at this moment. The limit does not include the vibration, which the hand should
  // feel.
  const bool goes_on = coupling.normal_force > 0 && l.last_force != dvec3(0);
  const bool begins_or_ends = lands(now) && (now.touching() || l.last_force != dvec3(0));
  if (now.in.cuts && !now.in.scrapes && (goes_on || begins_or_ends)) {
    const dvec3 change = force_change(now);
    const double size = glm::length(change);
    if (size > P::drilling_slew * now.dt) now.force -= change * (held_back(now, size) / size);
  }
  const bool fades = l.ending || (now.hand.faults & bits(Fault::kHeld));
  if (!now.touching() && !fades) l.ramp = 1;  // without contact, no force remains to which the ramp could apply
  if (fades || l.ramp < 1) {
    l.ramp = std::clamp(l.ramp + (fades ? -1 : 1) * now.dt / std::max(settings.ramp_time, now.dt), 0.0, 1.0);
  }
  const double magnitude = glm::length(now.force + now.spindle_force);
  double fraction = l.ramp;
  if (magnitude * fraction > settings.force_limit) {
    fraction = settings.force_limit / magnitude;
    now.faults |= bits(Fault::kForceLimit);
  }
  const double twist = glm::length(now.torque);
  if (twist * fraction > settings.torque_limit) {
    now.torque *= settings.torque_limit / (twist * fraction);
    now.faults |= bits(Fault::kForceLimit);
  }
  if (settings.slew_limit > 0) {
    const double risen = magnitude * fraction - glm::length(l.last_sent), most = settings.slew_limit * now.dt;
    if (risen > most) {
      fraction *= (magnitude * fraction - risen + most) / (magnitude * fraction);
      now.faults |= bits(Fault::kSlewLimit);
    }
  }
  if (fraction != 1) {
    now.force *= fraction;
    now.spindle_force *= fraction;
    now.teeth_force *= fraction;
    now.torque *= fraction;
  }
  // The torque of the spindle may use the part of the torque limit that the tissue's torque does not use.
  if (now.contact.holds_turn && now.spindle_torque != dvec3(0)) {
    now.spindle_torque *= std::min(
        fraction, std::max(0.0, settings.torque_limit - glm::length(now.torque)) / glm::length(now.spindle_torque));
  }
}

/// Limits the force if the energy ledger holds far less energy than the coupling stores. This happens after a fast
/// first contact, or if a tool starts inside tissue. Without this limit, the hand would bounce: passive_fraction()
/// would remove the force within a few ticks when the hand retreats, and restore it when the hand advances. The limit
/// begins with the hand's first retreat. The largest allowed force is that of a spring that stores exactly the ledger's
/// energy, so that spring and ledger become empty at the same time. Returns the fraction of the force that may stay.
double Servo::State::paid_fraction(const ContactTick& now) noexcept {
  Limits& l = limits;
  if (!(now.in.cuts || l.unpaid || now.contact.late)) return 1;
  if (now.contact.late) l.unpaid = true;
  const double k = settings.stiffness * coupling.relative_stiffness, paid = std::max(sums.energy + l.given, 0.0);
  const double most = std::sqrt(2 * k * paid + P::unpaid_force * P::unpaid_force), strength = glm::length(now.force);
  if (now.in.cuts && P::unpaid_ratio * most < strength && glm::dot(now.force, now.moved) > 0) l.unpaid = true;
  if (strength <= most && !now.contact.rejoining) l.unpaid = false;
  if (!(l.unpaid && strength > most)) return 1;
  return std::max(most, glm::length(l.last_force) - P::drilling_slew * now.dt) / strength;
}

/// Returns the factor 0..1 by which the force is reduced so that the energy E in the energy ledger is enough for the
/// hand's whole retreat, not only for the next tick. `at_stake`: J, energy that
/// the unreduced force may give to the hand in the next tick.
/// Two limits follow from E. (1) The force is at most √(2 k E), the force at which a spring of the stiffness k stores
/// E. (2) If the hand may retreat by Δ in a tick, passive_fraction() allows at most the force E / a, with a = Δ ×
/// PassivityLaw::margin. The function combines both without a step in value or slope: √(2 k E - k² a²) for E > k a²,
/// and E / a for smaller E.
double Servo::State::landing_fraction(const ContactTick& now, double at_stake) const noexcept {
  const Limits& l = limits;
  const double strength = glm::length(now.force);
  if (!(strength > 0)) return 1;
  const double k = settings.stiffness * std::max(coupling.relative_stiffness, now.contact.side_stiffness);
  const double paid = std::max(sums.energy + l.given, 0.0), slew = P::drilling_slew * now.dt;
  const double retreat = glm::dot(now.force, now.moved) / strength;  // m
  double most = 0;                                                   // N
  if (retreat > 0) {
    // The hand is expected to retreat as fast as it advanced.
    const double ahead = std::max(at_stake / strength, l.law.margin * l.passivity.pace.most * settings.tick);
    most = paid > k * ahead * ahead ? std::sqrt(2 * k * paid - k * k * ahead * ahead) : paid / ahead;
    // The coupling stores more energy than the energy ledger can pay for. If the force rose while the hand retreats,
    // the hand would get more energy than the ledger has. So the rise of the force is limited.
    if (paid < now.stored) {
      most = std::min(most, glm::length(l.last_force) + std::max(0.0, slew - P::retreat_weight * k * retreat));
    }
  } else {
    most = std::sqrt(2 * k * paid + P::unpaid_force * P::unpaid_force);
  }
  if (most >= strength) return 1;
  // The force decreases to `most` without a step: the limit of its change is the larger of the slew limit and the
  // change that the hand's own motion causes.
  const double allowed = std::max(slew, P::spring_tolerance * k * glm::length(now.moved)), excess = 1 - most / strength;
  return 1 - excess * largest_fraction(-excess * now.force, force_change(now), allowed);
}

/// Updates Coupling::teeth_fraction, the fraction of the coupling's force that presses the cutting edges. The force
/// that the hand feels presses the cutting edges against the tissue. If the hand has felt little of the coupling's
/// force for rest_time, for example after a jump into the tissue, the fraction rises to 1. Otherwise a hand at rest
/// would not cut and would give the ledger no energy, and the force would stay small.
void Servo::State::press_teeth(const ContactTick& now) noexcept {
  double& rest = coupling.unfelt_for;
  coupling.teeth_fraction = 1;
  if (!now.touching()) {
    rest = 0;
    return;
  }
  const double left = lands(now) && now.unlimited > 0 ? std::min(1.0, glm::length(now.force) / now.unlimited) : 1;
  rest = std::clamp(rest + (left < P::little_felt ? now.dt : -now.dt), 0.0, 2 * P::rest_time);
  coupling.teeth_fraction = std::max(left, std::clamp(rest / P::rest_time - 1, 0.0, 1.0));
}

dvec3 Servo::State::keep_passive(ContactTick& now) noexcept {
  Limits& l = limits;
  // The energy stored in the coupling may rise without work of the hand: if the input jumps towards the tissue, or
  // while the proxy leads a tool out of tissue in which it started. The energy ledger allows this energy while the
  // contact lasts. The hand's work must pay for any later rise.
  const bool began_in_tissue =
      now.contact.leading_out && to_seconds(now.hand.t - motion.began) < MotionParameters::leap_time;
  if (began_in_tissue || motion.leap > 0) {
    l.given += std::max(0.0, now.stored - l.stored - std::max(0.0, -now.given_to_hand));
  }
  // When a contact ends, the energy ledger may be in debt (sums.energy is negative). A ledger in debt would allow no
  // force at the next contact, so the debt is cancelled.
  if (!now.touching() && coupling.tip.sunk <= 0) l.given = std::clamp(-sums.energy, 0.0, cancelled_debt());
  l.stored = now.stored;
  // A device that gives no torque does not resist rotation, so its torque must not enter the energy ledger.
  dvec3 felt_torque = settings.gives_torque ? now.torque : dvec3(0);
  if (settings.passivity) {
    const double at_stake =
        energy_at_stake(l.law, now.force, now.moved, felt_torque, now.turned, now.dt, settings.tick, l.passivity);
    const bool landing = lands(now);
    double passive = landing ? 1 : paid_fraction(now);
    if (at_stake > 0) {
      if (landing) passive = landing_fraction(now, at_stake);
      passive = std::min(passive, std::clamp((sums.energy + l.given + l.law.credit) / at_stake, 0.0, 1.0));
    }
    if (passive != 1) {
      now.force *= passive;
      now.torque *= passive, felt_torque *= passive;
    }
  }
  press_teeth(now);
  return felt_torque;
}

}  // namespace typodont::haptics
