// Hand of the Inverse3 (Haply), through the WebSocket service of its vendor.
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
  dvec3 position{0};              // m, position of the handle in the device's frame
  dquat orientation{1, 0, 0, 0};  // orientation of the handle, if a Verse Grip is connected
  bool button = false;
};
/// Reads a state message; nullopt: invalid, or another kind of message. Never allocates.
std::optional<HaplyState> parse_haply(std::string_view message) noexcept;

/// `link`: open connection to the service. `claimed`: lock of the device. Throws Error if no device reports its state.
std::unique_ptr<HapticDevice> make_haply(std::unique_ptr<Link> link, const std::string& host, DeviceInfo identity,
                                         Descriptor claimed = {});

}  // namespace typodont::haptics
