#include "haptics/spindle.h"

#include "engine/base/units.h"

namespace typodont::haptics {

Spindle read_spindle(const Json& json) {
  json.allow_only(
      {"name", "free_speed_krpm", "stall_torque_Nmm", "held_torque_Nmm", "run_up_s", "handpiece", "spray", "source"});
  Spindle spindle;
  spindle.name = json["name"].string();
  spindle.free_speed = json["free_speed_krpm"].number(0.001, 1000) * kKrpm;
  spindle.stall_torque = json["stall_torque_Nmm"].number(0, 10000) * kMillimetre;
  if (const auto held = json.find("held_torque_Nmm")) {
    spindle.held_torque = held->number(0, 10000) * kMillimetre;
    if (!(spindle.held_torque < spindle.stall_torque)) held->fail("a torque below stall_torque_Nmm");
  }
  spindle.run_up_time = json.number_or("run_up_s", 0, 0, 10);
  spindle.handpiece = json.string_or("handpiece", "");
  if (const auto spray = json.find("spray")) {
    spray->allow_only(
        {"flow_ml_per_min", "nozzles", "ring_mm", "setback_mm", "cone_deg", "speed_m_per_s", "drops_um", "source"});
    Nozzles& nozzles = spindle.nozzles.emplace();
    nozzles.flow = (*spray)["flow_ml_per_min"].number(0.1, 500) * 1e-6 / 60;
    nozzles.count = static_cast<int>(spray->number_or("nozzles", nozzles.count, 1, 16));
    nozzles.ring_radius = spray->number_or("ring_mm", nozzles.ring_radius / kMillimetre, 0.5, 20) * kMillimetre;
    nozzles.setback = spray->number_or("setback_mm", nozzles.setback / kMillimetre, 0.5, 60) * kMillimetre;
    nozzles.cone = spray->number_or("cone_deg", nozzles.cone * 180 / kPi, 0, 40) * kPi / 180;
    nozzles.speed = spray->number_or("speed_m_per_s", nozzles.speed, 0.1, 60);
    if (const auto drops = spray->find("drops_um")) {
      const std::vector<double> range = drops->numbers(2);
      if (!(range[0] >= 1 && range[0] <= range[1] && range[1] <= 2000)) drops->fail("[least, greatest], 1 to 2000");
      nozzles.min_drop = range[0] * 1e-6, nozzles.max_drop = range[1] * 1e-6;
    }
  }
  return spindle;
}

}  // namespace typodont::haptics
