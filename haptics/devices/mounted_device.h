// Converts between the frames of a device and the workbench: poses from the device's base to W, and forces from W to
// the device's base.
#pragma once

#include <memory>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// Wraps a device, which uses its own base frame, in a device that uses frame W. X_WH is the pose of the device's base
/// in the workbench, and X_ST the pose of the tool's head relative to the stylus.
std::unique_ptr<HapticDevice> mount(std::unique_ptr<HapticDevice> device, const Pose& X_WH, const Pose& X_ST);

}  // namespace typodont::haptics
