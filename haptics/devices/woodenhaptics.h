// WoodenHaptics and Polhem arms over any link. The safety layer goes around it (open_hand does that).
#pragma once

#include <memory>

#include "haptics/devices/arm.h"
#include "haptics/devices/arm_protocol.h"
#include "haptics/devices/link.h"
#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// Wakes the board and learns from its first reports how it speaks: by report length for HID, lines for a serial link.
struct ArmHello {
  ArmProtocol protocol = ArmProtocol::kHidV1;
  int model = 0;  // as the board says; 0: it does not say
};
/// Throws Error naming `where` when nothing sensible is heard for a second.
ArmHello greet_arm(Link& link, bool serial, const std::string& where);

/// The arm must rest in its home position: that is where its encoders start. Its calibration button homes it again.
std::unique_ptr<HapticDevice> make_arm_device(std::unique_ptr<Link> link, ArmProtocol protocol, Arm arm,
                                              DeviceInfo identity);

}  // namespace typodont::haptics
