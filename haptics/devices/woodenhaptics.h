// WoodenHaptics and Polhem arms over any link. open_hand() adds the safety layer.
#pragma once

#include <memory>

#include "haptics/devices/arm.h"
#include "haptics/devices/arm_protocol.h"
#include "haptics/devices/link.h"
#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// Result of the first contact with a board: its protocol. An HID board is recognised by the length of its reports, a
/// serial board by its lines.
struct ArmHello {
  ArmProtocol protocol = ArmProtocol::kHidV1;
  int model = 0;  // number of the model, as the board reports it; 0: the board reports none
};
/// Wakes the board. Throws Error naming `where` if no valid answer arrives within a second.
ArmHello greet_arm(Link& link, bool serial, const std::string& where);

/// Makes the hand of an arm. The arm must rest in its home position, where its encoders start. The calibration button
/// homes it again.
std::unique_ptr<HapticDevice> make_arm_device(std::unique_ptr<Link> link, ArmProtocol protocol, Arm arm,
                                              DeviceInfo identity);

}  // namespace typodont::haptics
