// Limits for the forces of the motors on a hand. The functions and small classes are tested individually.
#pragma once

#include <cmath>

#include "engine/base/pose.h"
#include "engine/contract/safety_event.h"

namespace typodont::haptics {

struct SafetyLimits {
  double force = 5;          // N, largest force for a short time (peak force)
  double torque = 0;         // N·m, largest torque for a short time (peak torque)
  double continuous = 0;     // N, force that the motors can give permanently; 0 if it equals the peak force
  double thermal_time = 30;  // s, thermal time constant of the motor windings
  // N/s, slew limit; with this value, the full force is reached after a few ms. For comparison: if a hand that moves at
  // 1 m/s meets a surface of 2 N/mm, the force rises by 2000 N/s.
  double slew = 4000;
  double torque_slew = 40;  // N·m/s, slew limit of the torque
  // m/s; if the measured speed of the hand is above this, an encoder is broken or the arm is out of control
  double speed = 3;
  double ramp_in = 0.25;     // s, time in which the force rises after it was enabled
  double ramp_out = 0.015;   // s, time in which an emergency stop reduces the force to zero; it must be less than 20 ms
  double free_force = 0.02;  // N; the hand counts as free of contact if the model force is smaller than this
  double free_time = 0.05;   // s, time for which the hand must be free of contact before the force is enabled again
  double silence = 1.8e-3;   // s, time without a write after which the watchdog sends zero force
  double pedal_time = 120;   // s, time after which a pressed pedal counts as stuck
};

using typodont::bits;
using typodont::SafetyEvent;

/// Shortens v to the length `limit` if it is longer, and keeps its direction.
inline dvec3 clip_length(const dvec3& v, double limit) {
  const double length = glm::length(v);
  return length > limit ? v * (limit / length) : v;
}

/// Returns the force after one step from `last` towards `wanted`. An increase or a change of direction is limited to
/// `step`; a decrease is not limited. The result is never longer than `wanted`. So if `wanted` obeys a limit of the
/// magnitude, the result obeys it, too.
inline dvec3 limit_slew(const dvec3& last, const dvec3& wanted, double step) {
  const double was = glm::length(last), is = glm::length(wanted);
  const dvec3 start = was > is ? last * (is / was) : last;
  return start + clip_length(wanted - start, step);
}

/// Thermal model of the motor windings: one body whose heating is proportional to the square of the force. `heat` is 1
/// at the limit, which a constant force of the size `continuous` reaches after a long time.
struct ThermalModel {
  double heat = 0;

  /// Returns the largest force (N) that is allowed now. It is the peak force while the motors are cool. Above a heat of
  /// 0.9 it decreases to the continuous force.
  double allowed(const SafetyLimits& limits) const {
    if (limits.continuous <= 0 || limits.continuous >= limits.force) return limits.force;
    const double fade = glm::clamp((1 - heat) / 0.1, 0.0, 1.0);
    return limits.continuous + fade * (limits.force - limits.continuous);
  }
  void add(double force, double dt, const SafetyLimits& limits) {
    if (limits.continuous <= 0) return;
    const double load = force / limits.continuous;
    // this formula is exact for a constant force
    heat = load * load + (heat - load * load) * std::exp(-dt / limits.thermal_time);
  }
};

}  // namespace typodont::haptics
