// The motor of the bur: an ideal motor with constant speed, or one with a linear torque–speed curve.
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "engine/base/json.h"
#include "engine/contract/nozzles.h"

namespace typodont::haptics {

/// Linear torque–speed curve T = T_s (1 − ω/ω₀): exact for air turbines, approximate for electric handpieces and
/// implant motors.
struct Spindle {
  std::string name = "ideal";
  double free_speed = 0;    // rad/s at full pedal
  double stall_torque = 0;  // N·m at full pedal; 0: ideal motor, the speed does not fall under load
  double run_up_time = 0;   // s, time constant: 63 % of a speed change are done after this time; 0: immediate
  // the motor's handpiece in pictures, with the same values as Tool::handpiece; empty: a turbine
  std::string handpiece;
  std::optional<Nozzles> nozzles;  // the handpiece's water; not used by the servo
};

/// Speed and cutting power under a load of `torque`, at pedal 0..1. The spindle stalls (0, 0) above the stall torque.
struct SpindleLoad {
  double speed = 0;  // rad/s
  double power = 0;  // W available for cutting
};
inline SpindleLoad load_spindle(const Spindle& spindle, double free_speed_now, double pedal, double torque) noexcept {
  if (spindle.stall_torque <= 0) return {free_speed_now, torque * free_speed_now};
  const double stall = spindle.stall_torque * pedal;
  const double share = stall > 0 ? std::max(0.0, 1 - torque / stall) : 0.0;
  return {free_speed_now * share, torque * free_speed_now * share};
}

/// Reads a file of assets/motors/. Throws Error.
Spindle read_spindle(const Json& json);

}  // namespace typodont::haptics
