// Hands with WoodenHaptics or Polhem arms, over any link. open_hand() adds the safety layer.
#pragma once

#include <memory>

#include "haptics/devices/arm.h"
#include "haptics/devices/arm_protocol.h"
#include "haptics/devices/link.h"
#include "haptics/haptic_device.h"

namespace typodont::haptics {

/// Properties of a board, found by the first exchange of messages. A HID protocol is recognised by the length of
/// reports, the text protocol by its lines.
struct ArmHello {
  ArmProtocol protocol = ArmProtocol::kHidV1;
  int model = 0;  // number of the arm's model that the board reports; 0 if it reports none
};
/// Contacts a board for the first time. Throws an Error that names `where` if no valid answer comes within a second.
ArmHello greet_arm(Link& link, bool serial, const std::string& where);

/// Makes the hand of an arm. At the start, the arm must rest in its home position, from which the encoders count. The
/// calibration button defines the home position again.
std::unique_ptr<HapticDevice> make_arm_device(std::unique_ptr<Link> link, ArmProtocol protocol, Arm arm,
                                              DeviceInfo identity);

}  // namespace typodont::haptics
