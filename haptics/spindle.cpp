#include "haptics/spindle.h"

#include "engine/base/units.h"

namespace typodont::haptics {

Spindle read_spindle(const Json& json) {
  json.allow_only({"name", "free_speed_krpm", "stall_torque_Nmm", "run_up_s", "handpiece", "source"});
  Spindle spindle;
  spindle.name = json["name"].string();
  spindle.free_speed = json["free_speed_krpm"].number(0.001, 1000) * kKrpm;
  spindle.stall_torque = json["stall_torque_Nmm"].number(0, 10000) * kMillimetre;
  spindle.run_up_time = json.number_or("run_up_s", 0, 0, 10);
  spindle.handpiece = json.string_or("handpiece", "");
  return spindle;
}

}  // namespace typodont::haptics
