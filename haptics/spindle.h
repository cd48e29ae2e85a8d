// Motor of the bur: ideal, or with constant speed up to a certain torque, above which the speed falls linearly.
#pragma once

#include <algorithm>
#include <cmath>
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
  // Time constant with which the rotor's speed follows pedal and load, s; 0: at once.
  double run_up_time = 0;
  // Handpiece that is drawn with this motor (as Tool::handpiece); empty: a turbine.
  std::string handpiece;
  std::optional<Nozzles> nozzles;  // water and air nozzles; not used by the servo

  /// Fraction of a change of the speed that is still to come after a time (s).
  double lag(double time) const noexcept { return run_up_time > 0 ? std::exp(-time / run_up_time) : 0; }
  /// Part of the free speed at full pedal that a lasting load (N·m) takes away; above 1, the rotor stops. `pedal`:
  /// 0..1.
  double lost_fraction(double load, double pedal) const noexcept {
    return stall_torque > 0 ? std::max(0.0, load - held_torque * pedal) / (stall_torque - held_torque) : 0;
  }
};

/// Reads a file of assets/motors/. Throws Error.
Spindle read_spindle(const Json& json);

}  // namespace typodont::haptics
