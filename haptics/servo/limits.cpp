// Limits of the force: limits of the device, ramps at start and end, and the passivity controller with its ledger.
#include <algorithm>
#include <cmath>

#include "haptics/servo/state.h"

namespace typodont::haptics {

using P = LimitParameters;

void Servo::State::limit(ContactTick& now) noexcept {
  Limits& l = limits;
  // Limits the force change of a head that lands in its own cut, after a fall from a rim or through soft tissue. The
  // limit does not include the vibration, which the hand should feel.
  if (now.in.cuts && !now.in.scrapes && coupling.normal_force > 0 && l.last_force != dvec3(0)) {
    const dvec3 change = now.force + now.teeth_force - l.last_force - l.last_teeth_force;
    const double size = glm::length(change), over = size - P::drilling_slew * now.dt;
    if (over > 0) now.force -= change * (std::min(over, P::lag_limit) / size);
  }
  const bool fades = l.ending || (now.hand.faults & bits(Fault::kHeld));
  if (!now.touching() && !fades) l.ramp = 1;  // without contact, no force remains that the ramp could scale
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
  // The torque of the spindle may use the part of the torque limit that the tissue's torque does not use.
  if (now.contact.holds_turn && now.spindle_torque != dvec3(0)) {
    now.spindle_torque *= std::min(
        fraction, std::max(0.0, settings.torque_limit - glm::length(now.torque)) / glm::length(now.spindle_torque));
  }
}

/// Limits the force if the ledger holds far less energy than the coupling (after a hard landing, or for a tool that
/// started inside tissue). Without this limit, passive_fraction() would remove the force within a few ticks when the
/// hand retreats, and restore it when the hand advances: the hand would bounce. From the first retreat of such a hand
/// on, the force is at most that of a spring that stores the ledger's energy, so spring and ledger become empty
/// together. Returns the fraction of the force that may stay.
double Servo::State::paid_fraction(const ContactTick& now) noexcept {
  Limits& l = limits;
  if (settings.laws < 2 || !(now.in.cuts || l.unpaid || now.contact.late)) return 1;
  if (now.contact.late) l.unpaid = true;
  const double k = settings.stiffness * coupling.relative_stiffness, paid = std::max(sums.energy + l.given, 0.0);
  const double most = std::sqrt(2 * k * paid + P::unpaid_force * P::unpaid_force), strength = glm::length(now.force);
  if (now.in.cuts && P::unpaid_ratio * most < strength && glm::dot(now.force, now.moved) > 0) l.unpaid = true;
  if (strength <= most && !now.contact.rejoining) l.unpaid = false;
  if (!(l.unpaid && strength > most)) return 1;
  return std::max(most, glm::length(l.last_force) - P::drilling_slew * now.dt) / strength;
}

dvec3 Servo::State::keep_passive(ContactTick& now) noexcept {
  Limits& l = limits;
  // If the proxy leads a tool out of tissue in which the tool started, or if the input jumps towards the tissue, the
  // energy stored in the coupling rises without work of the hand. The ledger allows this energy while the contact
  // lasts. The hand's work must pay for any later rise.
  const bool began_in_tissue =
      now.contact.leading_out && to_seconds(now.hand.t - motion.began) < MotionParameters::leap_time;
  if (began_in_tissue || motion.leap > 0) {
    l.given += std::max(0.0, now.stored - l.stored - std::max(0.0, -now.given_to_hand));
  }
  // After the contact, the ledger may be in debt (negative sums.energy), and a ledger in debt would allow no force at
  // the next contact. Therefore the debt is cancelled, but at most by the energy l.given, which was allowed above. A
  // debt above most_debt() is cancelled completely, because it has other causes, for example late ticks, which hold a
  // force for longer than expected.
  const double forgiven = sums.energy < -most_debt() ? -sums.energy : l.given;
  if (!now.touching() && coupling.tip.sunk <= 0) l.given = std::clamp(-sums.energy, 0.0, forgiven);
  l.stored = now.stored;
  // A device that gives no torque does not resist rotation, so its torque must not enter the ledger.
  dvec3 felt_torque = settings.gives_torque ? now.torque : dvec3(0);
  if (settings.passivity) {
    double passive = passive_fraction(l.law, now.force, now.moved, felt_torque, now.turned, now.dt, settings.tick,
                                      sums.energy + l.given, l.passivity);
    passive = std::min(passive, paid_fraction(now));
    now.force *= passive;
    now.torque *= passive, felt_torque *= passive;
  }
  return felt_torque;
}

}  // namespace typodont::haptics
