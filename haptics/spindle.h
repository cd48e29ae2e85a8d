// What turns the bur: an ideal motor of constant speed, or one with a torque–speed line.
#pragma once

#include <algorithm>
#include <string>

#include "engine/base/json.h"

namespace typodont::haptics {

/// T = T_s (1 − ω/ω₀): straight for air turbines, nearly so for electric handpieces and implant motors.
struct Spindle {
  std::string name = "ideal";
  double free_speed = 0;    // rad/s at full pedal
  double stall_torque = 0;  // N·m at full pedal; 0: ideal, the speed never falls
  double run_up_time = 0;   // s to 63 % of a new speed; 0: at once
};

/// Speed and cutting power while the tissue asks for `torque` at pedal 0..1; stalls (0, 0) above the stall torque.
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

/// From a file of assets/motors/. Throws Error.
Spindle read_spindle(const Json& json);

}  // namespace typodont::haptics
