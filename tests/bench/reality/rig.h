// A machine that holds a tool against a slab, as the published experiments did, and what it measures.
#pragma once

#include <map>
#include <string>

namespace typodont::bench {

/// Of one run, as text by name: "tissue" (of the program, or of materials.json), "tool" (file; "diameter_mm" and
/// "length_mm" replace its own), "motor" (file; "free_krpm" replaces its speed) or "krpm" (ideal), "load_N" or
/// "feed_mm_s", "stroke_mm_s", "engaged_mm" (width of the slab), "depth_um", "rig_N_per_mm" (stiffness); of a tooth
/// "dentin_mm" above its pulp and "coolant_C" (without it: dry); of a worn tool "grit_um", "cuts" of "cut_mm", and the
/// cut "from_cut" with which the last is compared; of an implant "density" (g/cm³) of the bone and "bed_mm", its
/// diameter.
using Conditions = std::map<std::string, std::string, std::less<>>;

/// Over the steady part of a run.
struct Measured {
  double rate = 0;         // m³/s
  double feed = 0;         // m/s, along the push
  double force = 0;        // N, of the contact, normal
  double force_ratio = 0;  // tangential / normal
  double fall = 0;         // of the rate, from one cut to the last, by wear
  double torque = 0;       // N·m, on the spindle
  double energy = 0;       // J/m³
  double speed = 0;        // rad/s, of the spindle
  double free_speed = 0;   // rad/s
  double radius = 0;       // m, of the tool
  double pulp = 0;         // °C, at the end
};

/// `rig`: "face" (load on a face, strokes along it), "tooth" (the same on enamel over dentin and pulp), "slot" (load
/// along a slot of half the diameter), "mill" (feed along a slot of a given depth), "plunge" (load or feed along the
/// axis). `seconds`: the longest run. Throws Error.
Measured run_rig(const std::string& rig, const Conditions& conditions, double seconds);

/// Brakes a free bur from its free speed to standstill.
struct MotorCurve {
  double free_speed = 0;    // rad/s
  double stall_torque = 0;  // N·m
  double max_power = 0;     // W
  double power_at = 0;      // speed of the greatest power / free speed
};
MotorCurve brake(const Conditions& conditions);

/// Largest torque, N·m, of an implant of 4.1 × 10 mm (core 3.5 mm) in a bed in foam. `seconds`: the longest run.
double insert(const Conditions& conditions, double seconds);

}  // namespace typodont::bench
