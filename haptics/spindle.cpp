#include "haptics/spindle.h"

#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "haptics/described.h"

namespace typodont::haptics {

namespace {

constexpr Form kSizes{"[smallest, largest]", kPair.schema};

void describe_nozzles(Keys& keys, Nozzles& nozzles) {
  keys(must("flow_ml_per_min"), nozzles.flow, {0.1, 500, kMillilitrePerMinute}, "water, if the scene states no flow");
  double count = nozzles.count;
  keys("nozzles", count, {1, 16}, "number of nozzles");
  nozzles.count = static_cast<int>(count);
  keys("ring_mm", nozzles.ring_radius, {0.5, 20, kMillimetre}, "distance from the axis of the bur");
  keys("setback_mm", nozzles.setback, {0.5, 60, kMillimetre}, "distance from the free end of the bur, along its axis");
  keys("cone_deg", nozzles.cone, {0, 40, kDegree}, "standard deviation of a drop's angle to the aim");
  keys("speed_m_per_s", nozzles.speed, {0.1, 60}, "speed of the drops at the nozzle");
  if (const auto drops = keys("drops_um", kSizes, "diameters of the drops, 1–2000; default [80, 250]")) {
    const std::vector<double> range = drops->numbers(2);
    if (!(range[0] >= 1 && range[0] <= range[1] && range[1] <= 2000)) drops->fail("[least, greatest], 1 to 2000");
    nozzles.min_drop = range[0] * kMicrometre, nozzles.max_drop = range[1] * kMicrometre;
  }
  keys.ignore("source");
}

}  // namespace

void describe_spindle(Keys& keys, Spindle& spindle) {
  keys(must("name"), spindle.name, "name of the motor");
  keys(must("free_speed_krpm"), spindle.free_speed, {0.001, 1000, kKrpm}, "speed without load, 1000 rev/min");
  keys(must("stall_torque_Nmm"), spindle.stall_torque, {0, 10000, kMillimetre},
       "torque at which the motor stands still; 0: the speed is constant");
  keys("held_torque_Nmm", spindle.held_torque, {0, 10000, kMillimetre}, "torque up to which the motor holds its speed");
  if (keys.json() && keys.json()->has("held_torque_Nmm") && !(spindle.held_torque < spindle.stall_torque))
    (*keys.json())["held_torque_Nmm"].fail("a torque below stall_torque_Nmm");
  keys("run_up_s", spindle.run_up_time, {0, 10}, "time constant of a change of the speed");
  keys("handpiece", spindle.handpiece, "handpiece of this motor ([Handpieces](#handpieces))");
  keys("spray", spindle.nozzles, describe_nozzles, "water nozzles");
  keys.ignore("source");
}

Spindle read_spindle(const Json& json) {
  return read_keys(json, describe_spindle);
}

}  // namespace typodont::haptics
