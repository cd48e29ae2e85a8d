// What bounds the force: the device's limits, the ramps at start and end, and the energy ledger.
#include <algorithm>
#include <cmath>

#include "haptics/servo/state.h"

namespace typodont::haptics {

using P = LimitParameters;

void Servo::State::limit(ContactTick& now) noexcept {
  Limits& l = limits;
  // A hand that lands in its own cut, after a fall from the rim or through a soft place, is no step either. (What the
  // spindle sends through the arm is meant to be felt.)
  if (now.in.cuts && !now.in.scrapes && coupling.normal_force > 0 && l.last_force != dvec3(0)) {
    const dvec3 change = now.force + now.teeth_force - l.last_force - l.last_teeth_force;
    const double size = glm::length(change), over = size - P::drilling_slew * now.dt;
    if (over > 0) now.force -= change * (std::min(over, P::most_lag) / size);
  }
  const bool fades = l.ending || (now.hand.faults & bits(Fault::kHeld));
  if (!now.contact.touching && !fades) l.ramp = 1;  // begun in the open: nothing to ramp
  l.ramp = std::clamp(l.ramp + (fades ? -1 : 1) * now.dt / std::max(settings.ramp_time, now.dt), 0.0, 1.0);
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
  now.force *= fraction;
  now.spindle_force *= fraction;
  now.teeth_force *= fraction;
  now.torque *= fraction;
  // What the tissue's torque leaves of the limit.
  if (now.contact.holds_turn && now.spindle_torque != dvec3(0)) {
    now.spindle_torque *= std::min(
        fraction, std::max(0.0, settings.torque_limit - glm::length(now.torque)) / glm::length(now.spindle_torque));
  }
}

/// Where the ledger holds far less energy than the coupling (after a hard landing, or in a tool that was found inside
/// tissue), passive_share() takes the force away within a few ticks when the hand goes back, and gives it again when
/// the hand comes on: the hand bounces. From the first time that such a hand goes back, the force is at most that of a
/// spring which holds as much energy as the ledger, so that both end together. Returns the fraction of the force that
/// may stay.
double Servo::State::paid_fraction(const ContactTick& now) noexcept {
  Limits& l = limits;
  if (settings.laws < 2 || !(now.in.cuts || l.unpaid || now.contact.late)) return 1;
  if (now.contact.late) l.unpaid = true;
  const double k = settings.stiffness * coupling.relative_stiffness, paid = std::max(sums.energy + l.given, 0.0);
  const double most = std::sqrt(2 * k * paid + P::unpaid_force * P::unpaid_force), strength = glm::length(now.force);
  if (now.in.cuts && P::far_more * most < strength && glm::dot(now.force, now.moved) > 0) l.unpaid = true;
  if (strength <= most && !now.contact.rejoining) l.unpaid = false;
  if (!(l.unpaid && strength > most)) return 1;
  return std::max(most, glm::length(l.last_force) - P::drilling_slew * now.dt) / strength;
}

dvec3 Servo::State::keep_passive(ContactTick& now) noexcept {
  Limits& l = limits;
  // Leading a tool out of tissue that it was born in, or a leap of the input against it, raises what the coupling
  // stores without a hand's doing: that much is allowed for, as long as the contact lasts. What raises it later the
  // hand pays for.
  const bool born_inside =
      now.contact.leading_out && to_seconds(now.hand.t - motion.began) < MotionParameters::leap_time;
  if (born_inside || motion.leap > 0) {
    l.given += std::max(0.0, now.stored - l.stored - std::max(0.0, -now.given_to_hand));
  }
  // What the hand was given stays forgiven: a ledger in debt would never again allow a force. So is a debt of a contact
  // that is over, whatever brought it: ticks that came late hold a force for longer than was foreseen.
  const double forgiven = sums.energy < -most_debt() ? -sums.energy : l.given;
  if (!now.contact.touching && coupling.tip.sunk <= 0) l.given = std::clamp(-sums.energy, 0.0, forgiven);
  l.stored = now.stored;
  // An arm that gives no torque resists no turn, and none may be counted as if the hand had paid for it.
  dvec3 felt_torque = settings.gives_torque ? now.torque : dvec3(0);
  if (settings.passivity) {
    double passive = passive_share(l.law, now.force, now.moved, felt_torque, now.turned, now.dt, settings.tick,
                                   sums.energy + l.given, l.passivity);
    passive = std::min(passive, paid_fraction(now));
    now.force *= passive;
    now.torque *= passive, felt_torque *= passive;
  }
  return felt_torque;
}

}  // namespace typodont::haptics
