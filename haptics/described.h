// The keys of the files and blocks that haptics reads (engine/base/keys.h). Functions for set-up; they throw Error.
#pragma once

#include "haptics/spindle.h"
#include "haptics/tool.h"

namespace typodont {
class Keys;
}

namespace typodont::haptics {

void describe_tool(Keys& keys, Tool& tool);
void describe_spindle(Keys& keys, Spindle& spindle);
/// Describes the block "implant" of a tool. `diameter`, `length`: size of the head, m.
void describe_implant_tool(Keys& keys, ImplantTool& tool, double diameter, double length);

struct HandModel;
void describe_hand(Keys& keys, HandModel& model);  // HAND.json
void list_arm(Keys& keys);                         // a preset of assets/devices/

dvec3 read_direction_into_bone(const Json& json);

}  // namespace typodont::haptics
