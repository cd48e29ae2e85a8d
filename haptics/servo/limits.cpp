// What bounds the force: the device's limits, the ramps at start and end, and the energy ledger.
#include <algorithm>
#include <cmath>

#include "haptics/servo/state.h"

namespace typodont::haptics {

namespace {

constexpr double kDrillingSlew = 18.5;  // N/s, no faster does the force change while a bur cuts, hand and all, …
constexpr double kMostLag = 0.05;       // N, … where it need not stay behind by more than this for it
constexpr double kUnpaidForce = 0.1;    // N that the coupling may give although the ledger holds nothing
constexpr double kFarMore = 2;          // times the force that the ledger's energy is worth

}  // namespace

void Servo::State::limit(Touch& now) noexcept {
  // A hand that lands in its own cut, after a fall from the rim or through a soft place, is no step either. (What the
  // spindle sends through the arm is meant to be felt.)
  if (now.may_cut && !now.scrapes && normal_force > 0 && last_force != dvec3(0)) {
    const dvec3 change = now.force + now.teeth_force - last_force - last_teeth_force;
    const double size = glm::length(change), over = size - kDrillingSlew * now.dt;
    if (over > 0) now.force -= change * (std::min(over, kMostLag) / size);
  }
  if (!now.touching && !ending) ramp = 1;  // begun in the open: nothing to ramp
  ramp = std::clamp(ramp + (ending ? -1 : 1) * now.dt / std::max(settings.ramp_time, now.dt), 0.0, 1.0);
  const double magnitude = glm::length(now.force + now.spindle_force);
  double share = ramp;
  if (magnitude * share > settings.force_limit) {
    share = settings.force_limit / magnitude;
    now.faults |= bits(Fault::kForceLimit);
  }
  const double twist = glm::length(now.torque);
  if (twist * share > settings.torque_limit) {
    now.torque *= settings.torque_limit / (twist * share);
    now.faults |= bits(Fault::kForceLimit);
  }
  if (settings.slew_limit > 0) {
    const double risen = magnitude * share - glm::length(last_sent), most = settings.slew_limit * now.dt;
    if (risen > most) {
      share *= (magnitude * share - risen + most) / (magnitude * share);
      now.faults |= bits(Fault::kSlewLimit);
    }
  }
  now.force *= share;
  now.spindle_force *= share;
  now.teeth_force *= share;
  now.torque *= share;
}

dvec3 Servo::State::keep_passive(Touch& now) noexcept {
  // Leading a tool out of tissue that it was born in, or a leap of the input against it, raises what the coupling
  // stores without a hand's doing: that much is allowed for, as long as the contact lasts. What raises it later the
  // hand pays for.
  const bool born_inside = overlap > 0 && to_seconds(now.hand.t - began) < kLeapTime;
  if (born_inside || leap > 0) given += std::max(0.0, now.stored - stored - std::max(0.0, -now.given_to_hand));
  // What the hand was given stays forgiven: a ledger in debt would never again allow a force. So is a debt of a contact
  // that is over, whatever brought it: ticks that came late hold a force for longer than was foreseen.
  const double forgiven = sums.energy < -kDebt ? -sums.energy : given;
  if (!now.touching && tip.sunk <= 0) given = std::clamp(-sums.energy, 0.0, forgiven);
  stored = now.stored;
  // An arm that gives no torque resists no turn, and none may be counted as if the hand had paid for it.
  dvec3 felt_torque = settings.gives_torque ? now.torque : dvec3(0);
  if (settings.passivity) {
    double passive = passive_share(passivity_law, now.force, now.moved, felt_torque, now.turned, now.dt, settings.tick,
                                   sums.energy + given, passivity);
    // Where the ledger holds far less energy than the coupling (after a hard landing, or in a tool that was found
    // inside tissue), passive_share takes the force away within a few ticks when the hand goes back and gives it again
    // when the hand comes on, so the hand bounces. From the first time that such a hand goes back, the force is at most
    // that of a spring which holds as much energy as the ledger: both end together.
    const double k = settings.stiffness * stiffness_share, paid = std::max(sums.energy + given, 0.0);
    const double most = std::sqrt(2 * k * paid + kUnpaidForce * kUnpaidForce), strength = glm::length(now.force);
    if (now.may_cut && kFarMore * most < strength && glm::dot(now.force, now.moved) > 0) unpaid = true;
    if (strength <= most && rejoining == 0) unpaid = false;
    if (unpaid && strength > most) {
      const double eased = std::max(most, glm::length(last_force) - kDrillingSlew * now.dt);
      passive = std::min(passive, eased / strength);
    }
    now.force *= passive;
    now.torque *= passive, felt_torque *= passive;
  }
  return felt_torque;
}

}  // namespace typodont::haptics
