// A device where the rig has put it, holding the tool: poses from its base to the workbench, forces back.
#pragma once

#include <memory>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// X_WH: the device's base in the workbench. X_ST: the tool's head as seen from the stylus.
std::unique_ptr<HapticDevice> mount(std::unique_ptr<HapticDevice> device, const Pose& X_WH, const Pose& X_ST);

}  // namespace typodont::haptics
