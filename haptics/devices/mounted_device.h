// Converts between a device's frames and the workbench: poses from the device's base to W, forces from W to the base.
#pragma once

#include <memory>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// Wraps a device with its frames. X_WH: pose of the device's base in the workbench. X_ST: pose of the tool's head
/// relative to the stylus.
std::unique_ptr<HapticDevice> mount(std::unique_ptr<HapticDevice> device, const Pose& X_WH, const Pose& X_ST);

}  // namespace typodont::haptics
