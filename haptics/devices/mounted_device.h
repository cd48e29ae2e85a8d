// Converts between the frame of a device's base and the workbench frame W: poses from the base to W, and forces from W
// to the base.
#pragma once

#include <memory>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// Wraps a device, which uses its own base frame, in a device that uses the workbench frame W. X_WH is the pose of the
/// device's base in the workbench, and X_ST the pose of the tool's head relative to the stylus.
std::unique_ptr<HapticDevice> mount(std::unique_ptr<HapticDevice> device, const Pose& X_WH, const Pose& X_ST);

}  // namespace typodont::haptics
