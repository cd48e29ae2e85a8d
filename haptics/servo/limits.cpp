// Limits of the device, ramps, and the passivity controller with its energy ledger. Servo thread only.
#include <algorithm>
#include <cmath>

#include "haptics/servo/state.h"

namespace typodont::haptics {

using P = LimitParameters;

bool Servo::State::lands(const ContactTick& now) noexcept {
  return now.in.removal.cuts && !now.contact.spring.whole;
}

dvec3 Servo::State::force_change(const ContactTick& now) const noexcept {
  return now.force + now.teeth_force - limits.last_force - limits.last_teeth_force;
}

/// Part of `change` (N) that is delayed because it exceeds the slew limit. A delay costs energy, so a change that the
/// hand's motion causes is not delayed in retreat, and by at most lag_limit in approach.
double Servo::State::held_back(const ContactTick& now, double change) const noexcept {
  const double over = change - P::drilling_slew * now.dt;
  if (!lands(now)) return std::min(over, P::lag_limit);
  const double k = settings.stiffness * coupling.relative_stiffness;
  const double beyond = std::max(0.0, change - P::spring_tolerance * k * glm::length(now.moved));
  if (glm::dot(now.moved, limits.last_force != dvec3(0) ? limits.last_force : now.force) > 0) {
    // Retreat: delays only the change that exceeds both drilling_slew and the change by the hand's displacement.
    return std::min(over, beyond);
  }
  // The hand approaches: when a drill breaks through the end of an implant bed, the force drops. At most lag_limit of
  // this drop is delayed, so that the breakthrough is felt at once.
  const bool falls =
      glm::length(now.force + now.teeth_force) < glm::length(limits.last_force + limits.last_teeth_force);
  const bool perforates = falls && now.contact.orientation.held && !turning.lags;
  return std::min(over, perforates ? P::lag_limit : std::max(P::lag_limit, beyond));
}

void Servo::State::limit(ContactTick& now) noexcept {
  Limits& l = limits;
  now.unlimited = now.force != dvec3(0) ? glm::length(now.force) : 0;
  // Limits the change of the force when a cutting tool touches tissue again after it slipped off an edge or through
  // soft tissue. Does not limit the vibration, which should be felt.
  const bool goes_on = coupling.normal_force > 0 && l.last_force != dvec3(0);
  const bool begins_or_ends = lands(now) && (now.touching() || l.last_force != dvec3(0));
  if (now.in.removal.cuts && (goes_on || begins_or_ends)) {
    const dvec3 change = force_change(now);
    const double size = glm::length(change);
    if (size > P::drilling_slew * now.dt) now.force -= change * (held_back(now, size) / size);
  }
  const bool stopped = now.hand.faults & bits(Fault::kHeld);
  if (!now.touching() && !l.ending) l.ramp = 1;  // there is no force that the ramp could change
  if (l.ending || l.ramp < 1) {
    l.ramp = std::clamp(l.ramp + (l.ending ? -1 : 1) * now.dt / std::max(settings.ramp_time, now.dt), 0.0, 1.0);
  }
  if (stopped) l.ramp = 0;
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
  // The spindle's torque may be as large as the torque limit minus the tissue's torque.
  if (now.contact.orientation.held && now.spindle_torque != dvec3(0)) {
    now.spindle_torque *= std::min(
        fraction, std::max(0.0, settings.torque_limit - glm::length(now.torque)) / glm::length(now.spindle_torque));
  }
}

/// Returns the allowed fraction of the force. After the carver was late, this is less than 1 until the ledger has as
/// much energy as the coupling stores.
double Servo::State::paid_fraction(const ContactTick& now) noexcept {
  Limits& l = limits;
  l.unpaid |= now.contact.gap.late;
  if (!l.unpaid) return 1;
  const double paid = std::max(sums.energy + l.given, 0.0), strength = glm::length(now.force);
  // N²/J; a spring with this constant k stores force² / k
  const double k = now.contact.spring.whole && now.stored > 0 ? strength * strength / now.stored
                                                              : 2 * settings.stiffness * coupling.relative_stiffness;
  const double most = std::sqrt(k * paid + P::unpaid_force * P::unpaid_force);
  if (strength > most) return std::max(most, glm::length(l.last_force) - P::drilling_slew * now.dt) / strength;
  if (!now.contact.gap.rejoining) l.unpaid = false;
  return 1;
}

/// Returns a factor (0..1) for the force, such that the energy E in the ledger suffices for the hand's whole retreat.
/// Allowed force: √(2 k E - k² a²) for E > k a², otherwise E / a; k: stiffness; a: largest retreat of the hand that is
/// expected per tick. `at_stake`: J, energy of the full force in the next tick.
double Servo::State::landing_fraction(const ContactTick& now, double at_stake) const noexcept {
  const Limits& l = limits;
  const double strength = glm::length(now.force);
  if (!(strength > 0)) return 1;
  const double k = settings.stiffness * std::max(coupling.relative_stiffness, now.contact.wall.stiffness);
  const double paid = std::max(sums.energy + l.given, 0.0), slew = P::drilling_slew * now.dt;
  const double retreat = glm::dot(now.force, now.moved) / strength;  // m, retreat of the hand in this tick
  double most = 0;                                                   // N, largest allowed force
  if (retreat > 0) {
    // m, largest retreat expected in the next tick: the hand may retreat as fast as it advanced
    const double ahead = std::max(at_stake / strength, l.law.margin * l.passivity.speed.most * settings.tick);
    most = paid > k * ahead * ahead ? std::sqrt(2 * k * paid - k * k * ahead * ahead) : paid / ahead;
    // If the coupling stores more energy than the ledger has, an increase of the force during retreat would return more
    // energy than the ledger has. So the increase is limited.
    if (paid < now.stored) {
      most = std::min(most, glm::length(l.last_force) + std::max(0.0, slew - P::retreat_weight * k * retreat));
    }
  } else {
    most = std::sqrt(2 * k * paid + P::unpaid_force * P::unpaid_force);
  }
  if (most >= strength) return 1;
  // Reduces the force towards `most`. Largest change: slew limit or, if larger, the change by the hand's motion.
  const double allowed = std::max(slew, P::spring_tolerance * k * glm::length(now.moved)), excess = 1 - most / strength;
  return 1 - excess * max_fraction(-excess * now.force, force_change(now), allowed);
}

/// Sets teeth_fraction, the part of the force that presses the cutting edges: usually the part that the user feels. If
/// this is small for rest_time (after a jump into tissue), it rises to 1; otherwise a resting hand would not cut.
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
  // Stored energy may rise without work of the hand: by a jump of the input, or while the proxy is moved out of tissue.
  // This energy is allowed during the contact; later increases need work of the hand.
  const bool began_in_tissue =
      now.contact.leading_out && to_seconds(now.hand.t - motion.began) < MotionParameters::leap_time;
  if (began_in_tissue || motion.leap > 0) {
    l.given += std::max(0.0, now.stored - l.stored - std::max(0.0, -now.given_to_hand));
  }
  // After contact, an energy deficit is cancelled, because it would allow no force at the next contact.
  if (!now.touching() && coupling.tip.penetration <= 0) l.given = std::clamp(-sums.energy, 0.0, cancelled_deficit());
  l.stored = now.stored;
  // A device without torque output does not resist rotation, so the ledger ignores rotation.
  dvec3 felt_torque = settings.gives_torque ? now.torque : dvec3(0);
  if (settings.passivity) {
    const double at_stake =
        energy_at_stake(l.law, now.force, now.moved, felt_torque, now.turned, now.dt, settings.tick, l.passivity);
    const bool landing = lands(now);
    double passive = landing ? 1 : paid_fraction(now);
    if (at_stake > 0) {
      // Also where the contact model computes the force: otherwise its force would step when energy is lacking.
      if (landing || (now.in.removal.cuts && now.contact.spring.whole)) {
        passive = std::min(passive, landing_fraction(now, at_stake));
      }
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
