// Limits of motor forces, tested one by one.
#pragma once

#include <cmath>

#include "engine/base/pose.h"
#include "engine/contract/safety_event.h"

namespace typodont::haptics {

struct SafetyLimits {
  double force = 5;          // N, largest force for a short time (peak force)
  double torque = 0;         // N·m, largest torque for a short time (peak torque)
  double continuous = 0;     // N, permanent force; 0: the peak
  double thermal_time = 30;  // s, thermal time constant of the motor windings
  // N/s: full force in a few ms. (1 m/s into 2 N/mm: 2000 N/s.)
  double slew = 4000;
  double torque_slew = 40;  // N·m/s, slew limit of the torque
  // m/s of the hand; faster: broken encoder, or out of control
  double speed = 3;
  double ramp_in = 0.25;     // s, time in which the force rises after it was enabled
  double free_force = 0.02;  // N, model force below which the hand is free of contact
  double free_time = 0.05;   // s free of contact before the force returns
  double silence = 1.8e-3;   // s without a write, then the watchdog sends zero force
  double pedal_time = 120;   // s, time after which a pressed pedal counts as stuck
};

using typodont::bits;
using typodont::SafetyEvent;

/// Keeps the direction.
inline dvec3 clip_length(const dvec3& v, double limit) {
  const double length = glm::length(v);
  return length > limit ? v * (limit / length) : v;
}

/// From `last` to `wanted`: increases and turns by `step`, decreases at once, never longer than `wanted`.
inline dvec3 limit_slew(const dvec3& last, const dvec3& wanted, double step) {
  const double was = glm::length(last), is = glm::length(wanted);
  const dvec3 start = was > is ? last * (is / was) : last;
  return start + clip_length(wanted - start, step);
}

/// One body, heating ∝ force². 1: limit, reached by `continuous` in the long run.
struct ThermalModel {
  double heat = 0;

  /// N: peak when cool, from 0.9 down to continuous.
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
