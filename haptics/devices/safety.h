// Limits of motor forces, as separate functions that are tested one by one.
#pragma once

#include <cmath>

#include "engine/base/pose.h"
#include "engine/contract/safety_event.h"

namespace typodont::haptics {

struct SafetyLimits {
  double force = 5;          // N, largest force for a short time (peak force)
  double torque = 0;         // N·m, largest torque for a short time (peak torque)
  double continuous = 0;     // N, force that the motors can give permanently; 0: the peak force
  double thermal_time = 30;  // s, thermal time constant of the motor windings
  // Largest rate at which the force rises, N/s. (A hand at 1 m/s against a spring of 2 N/mm needs 2000 N/s.)
  double slew = 4000;
  double torque_slew = 40;  // N·m/s, slew limit of the torque
  // Largest speed of the hand, m/s; above it, an encoder is broken or the arm out of control.
  double speed = 3;
  double ramp_in = 0.25;     // s, time in which the force rises to its full value after the motors were armed
  double free_force = 0.02;  // N, computed force below which the tool counts as free of contact
  double free_time = 0.05;   // s, time free of contact after which the force returns
  double silence = 1.8e-3;   // s, time without a write after which the watchdog sends zero force
  double pedal_time = 120;   // s, time after which a pressed pedal counts as stuck
};

using typodont::bits;
using typodont::SafetyEvent;

/// Limits the length of a vector, and keeps its direction.
inline dvec3 clip_length(const dvec3& v, double limit) {
  const double length = glm::length(v);
  return length > limit ? v * (limit / length) : v;
}

/// Force between `last` and `wanted`: increases and turns by at most `step`, decreases at once, never longer than
/// `wanted`.
inline dvec3 limit_slew(const dvec3& last, const dvec3& wanted, double step) {
  const double was = glm::length(last), is = glm::length(wanted);
  const dvec3 start = was > is ? last * (is / was) : last;
  return start + clip_length(wanted - start, step);
}

/// Thermal model of the motors as one body, heated in proportion to force². The limit is heat = 1; a constant force
/// of SafetyLimits::continuous approaches it.
struct ThermalModel {
  double heat = 0;

  /// Allowed force, N: the peak force below heat 0.9, then falling to the continuous force at heat 1.
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
