// Converts poses from the frame of a device's base to W, and forces back.
#pragma once

#include <memory>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// `X_WH`: pose of the base on the workbench; `X_ST`: pose of the tool's head in the stylus.
std::unique_ptr<HapticDevice> mount(std::unique_ptr<HapticDevice> device, const Pose& X_WH, const Pose& X_ST);

}  // namespace typodont::haptics
