// Limits on what a motor may do to a hand: pure functions and small states, each tested alone.
#pragma once

#include <cmath>

#include "engine/base/pose.h"
#include "engine/contract/safety_event.h"

namespace typodont::haptics {

struct SafetyLimits {
  double force = 5;          // N, peak
  double torque = 0;         // N·m, peak
  double continuous = 0;     // N that the motors bear for ever; 0: as the peak
  double thermal_time = 30;  // s, time constant of the windings
  double slew = 4000;        // N/s: full force in a few ms; a contact at 2 N/mm met at 1 m/s rises by 2000 N/s
  double torque_slew = 40;   // N·m/s
  double speed = 3;          // m/s of the hand: faster means a broken encoder or a runaway arm
  double ramp_in = 0.25;     // s
  double ramp_out = 0.015;   // s, of an emergency stop while all is well otherwise; under 20 ms
  double free_force = 0.02;  // N: a servo that asks for less is free of contact …
  double free_time = 0.05;   // s: … and has been so for this long before force is allowed again
  double silence = 1.8e-3;   // s without a write, after which the watchdog sends zero
  double pedal_time = 120;   // s a pedal may be held before it counts as stuck
};

using typodont::bits;
using typodont::SafetyEvent;

/// No longer than `limit`, same direction.
inline dvec3 clip_length(const dvec3& v, double limit) {
  const double length = glm::length(v);
  return length > limit ? v * (limit / length) : v;
}

/// From `last` towards `wanted`: growth and turning take at most `step`; letting go is never delayed. The result is
/// never longer than `wanted`, so no limit kept by `wanted` is broken.
inline dvec3 limit_slew(const dvec3& last, const dvec3& wanted, double step) {
  const double was = glm::length(last), is = glm::length(wanted);
  const dvec3 start = was > is ? last * (is / was) : last;
  return start + clip_length(wanted - start, step);
}

/// Windings as one first-order body heated by the square of the force. 1 is as warm as they may become, the steady
/// state at the continuous force.
struct ThermalModel {
  double heat = 0;

  /// N, the most that is allowed now: the peak while cool, fading to the continuous force from 90 % warm on.
  double allowed(const SafetyLimits& limits) const {
    if (limits.continuous <= 0 || limits.continuous >= limits.force) return limits.force;
    const double fade = glm::clamp((1 - heat) / 0.1, 0.0, 1.0);
    return limits.continuous + fade * (limits.force - limits.continuous);
  }
  void add(double force, double dt, const SafetyLimits& limits) {
    if (limits.continuous <= 0) return;
    const double load = force / limits.continuous;
    heat = load * load + (heat - load * load) * std::exp(-dt / limits.thermal_time);  // exact for a constant load
  }
};

}  // namespace typodont::haptics
