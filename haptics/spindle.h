// The motor of the bur: either an ideal motor with constant speed, or a motor with a linear torque–speed curve.
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "engine/base/json.h"
#include "engine/contract/nozzles.h"

namespace typodont::haptics {

/// A motor with the linear torque–speed curve T = T_s (1 − ω/ω₀). This curve is exact for air turbines, and approximate
/// for electric handpieces and implant motors.
struct Spindle {
  std::string name = "ideal";
  double free_speed = 0;    // rad/s, speed ω₀ without load, at full pedal
  double stall_torque = 0;  // N·m, stall torque T_s at full pedal; 0: ideal motor, whose speed does not fall under load
  // s, time constant of a change of the speed (after this time, 63 % of the change is done); 0: the speed changes at
  // once
  double run_up_time = 0;
  // Handpiece that the renderer shows with this motor (values as in Tool::handpiece); empty: a turbine.
  std::string handpiece;
  std::optional<Nozzles> nozzles;  // water nozzles of the handpiece; the servo does not use them
};

/// Speed and cutting power of a spindle under a given load torque, at a pedal position 0..1. Above the stall torque,
/// both are 0.
struct SpindleLoad {
  double speed = 0;  // rad/s, speed under load
  double power = 0;  // W, power available for cutting
};
inline SpindleLoad load_spindle(const Spindle& spindle, double free_speed_now, double pedal, double torque) noexcept {
  if (spindle.stall_torque <= 0) return {free_speed_now, torque * free_speed_now};
  const double stall = spindle.stall_torque * pedal;
  const double fraction = stall > 0 ? std::max(0.0, 1 - torque / stall) : 0.0;
  return {free_speed_now * fraction, torque * free_speed_now * fraction};
}

/// Reads a motor from a file of assets/motors/. Throws Error.
Spindle read_spindle(const Json& json);

}  // namespace typodont::haptics
