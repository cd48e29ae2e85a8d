// Motor of the bur: ideal, or with constant speed up to a certain torque, above which the speed falls linearly.
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "engine/base/json.h"
#include "engine/contract/nozzles.h"

namespace typodont::haptics {

/// Torque T at the speed ω: T = T_h + (T_s − T_h) (1 − ω/ω₀). T_s: stall torque. T_h: torque up to which a controlled
/// electric motor keeps the speed ω₀; 0 for an air turbine.
struct Spindle {
  std::string name = "ideal";
  double free_speed = 0;    // rad/s, ω₀: speed without load, at full pedal
  double stall_torque = 0;  // N·m, stall torque T_s at full pedal; 0: ideal motor, whose speed does not fall under load
  double held_torque = 0;   // N·m, T_h at full pedal: torque up to which the motor keeps its speed
  // Time constant with which the speed follows the pedal, s; 0: the speed changes at once.
  double run_up_time = 0;
  // Handpiece that is drawn with this motor (as Tool::handpiece); empty: a turbine.
  std::string handpiece;
  std::optional<Nozzles> nozzles;  // water and air nozzles; not used by the servo
};

/// Speed and power under a load. At more than the stall torque, both are 0.
struct SpindleLoad {
  double speed = 0;  // rad/s, speed under load
  double power = 0;  // W, power available for cutting
};
inline SpindleLoad load_spindle(const Spindle& spindle, double free_speed_now, double pedal, double torque) noexcept {
  if (spindle.stall_torque <= 0) return {free_speed_now, torque * free_speed_now};
  const double stall = spindle.stall_torque * pedal, held = spindle.held_torque * pedal;
  const double fraction = stall > 0 ? std::clamp(1 - (torque - held) / (stall - held), 0.0, 1.0) : 0.0;
  return {free_speed_now * fraction, torque * free_speed_now * fraction};
}

/// Reads a file of assets/motors/. Throws Error.
Spindle read_spindle(const Json& json);

}  // namespace typodont::haptics
