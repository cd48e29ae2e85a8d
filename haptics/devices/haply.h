// Driver for Haply Inverse3 through its local WebSocket service.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string_view>

#include "haptics/devices/fd_link.h"
#include "haptics/devices/link.h"
#include "haptics/haptic_device.h"

namespace typodont::haptics {

struct HaplyState {
  std::array<char, 40> id{};      // identifier of the Inverse3, zero-terminated
  dvec3 position{0};              // m
  dquat orientation{1, 0, 0, 0};  // orientation of the Verse Grip, if the device has one
  bool button = false;
};
/// Parses one message of the service. Returns nothing for messages of another kind and for invalid messages. Never
/// allocates.
std::optional<HaplyState> parse_haply(std::string_view message) noexcept;

/// `link` is connected to the service. Throws Error if the service does not answer with a device. `claimed` stays
/// open as long as the device.
std::unique_ptr<HapticDevice> make_haply(std::unique_ptr<Link> link, const std::string& host, DeviceInfo identity,
                                         Descriptor claimed = {});

}  // namespace typodont::haptics
