// The bur's motor: ideal, or with a linear torque–speed curve, at first at a held speed.
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "engine/base/json.h"
#include "engine/contract/nozzles.h"

namespace typodont::haptics {

/// T = T_h + (T_s − T_h) (1 − ω/ω₀). Up to T_h a controlled electric motor holds ω₀; T_h = 0: an air turbine.
struct Spindle {
  std::string name = "ideal";
  double free_speed = 0;    // rad/s, speed ω₀ without load, at full pedal
  double stall_torque = 0;  // N·m, T_s at full pedal; 0: ideal, no drop under load
  double held_torque = 0;   // N·m, T_h at full pedal
  // s, time constant of the speed; 0: at once
  double run_up_time = 0;
  // Drawn with this motor (as Tool::handpiece); empty: a turbine.
  std::string handpiece;
  std::optional<Nozzles> nozzles;  // not used by the servo
};

/// Under a load, pedal 0..1. Above stall torque both are 0.
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

/// Of assets/motors/. Throws Error.
Spindle read_spindle(const Json& json);

}  // namespace typodont::haptics
