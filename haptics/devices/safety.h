// Limits on the motors' effect on a hand: pure functions and small states that are tested individually.
#pragma once

#include <cmath>

#include "engine/base/pose.h"
#include "engine/contract/safety_event.h"

namespace typodont::haptics {

struct SafetyLimits {
  double force = 5;          // N, peak
  double torque = 0;         // N·m, peak
  double continuous = 0;     // N, force that the motors can give permanently; 0: the same as the peak
  double thermal_time = 30;  // s, time constant of the windings
  // N/s, slew limit: full force in a few ms. For comparison: at 1 m/s, a contact of 2 N/mm rises by 2000 N/s
  double slew = 4000;
  double torque_slew = 40;   // N·m/s, slew limit
  double speed = 3;          // m/s, speed limit of the hand: a higher speed indicates a broken encoder or a runaway arm
  double ramp_in = 0.25;     // s, time in which the force rises after it was enabled
  double ramp_out = 0.015;   // s, time in which an emergency stop reduces the force to zero; must be below 20 ms
  double free_force = 0.02;  // N, limit: with a smaller model force, the hand counts as free of contact
  double free_time = 0.05;   // s, time for which the hand must be free of contact before force is enabled again
  double silence = 1.8e-3;   // s, time without a write after which the watchdog sends zero
  double pedal_time = 120;   // s, time after which a pressed pedal counts as stuck
};

using typodont::bits;
using typodont::SafetyEvent;

/// Limits the length of v and keeps its direction.
inline dvec3 clip_length(const dvec3& v, double limit) {
  const double length = glm::length(v);
  return length > limit ? v * (limit / length) : v;
}

/// Moves from `last` towards `wanted`. An increase and a rotation are limited to `step`; a decrease is never delayed.
/// The result is never longer than `wanted`, so a limit that `wanted` satisfies stays satisfied.
inline dvec3 limit_slew(const dvec3& last, const dvec3& wanted, double step) {
  const double was = glm::length(last), is = glm::length(wanted);
  const dvec3 start = was > is ? last * (is / was) : last;
  return start + clip_length(wanted - start, step);
}

/// The motor windings as one first-order body heated by the square of the force. 1 is the limit: the steady state at
/// the continuous force.
struct ThermalModel {
  double heat = 0;

  /// Largest force allowed now, N: the peak while the motors are cool; above 90 % heat the value decreases to the
  /// continuous force.
  double allowed(const SafetyLimits& limits) const {
    if (limits.continuous <= 0 || limits.continuous >= limits.force) return limits.force;
    const double fade = glm::clamp((1 - heat) / 0.1, 0.0, 1.0);
    return limits.continuous + fade * (limits.force - limits.continuous);
  }
  void add(double force, double dt, const SafetyLimits& limits) {
    if (limits.continuous <= 0) return;
    const double load = force / limits.continuous;
    heat = load * load + (heat - load * load) * std::exp(-dt / limits.thermal_time);  // exact for a constant force
  }
};

}  // namespace typodont::haptics
