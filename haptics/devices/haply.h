// Haply Inverse3 through its local WebSocket service.
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
  std::array<char, 40> id{};      // of the Inverse3, zero-terminated
  dvec3 position{0};              // m
  dquat orientation{1, 0, 0, 0};  // of the Verse Grip, where there is one
  bool button = false;
};
/// One message of the service; nothing for other messages and for garbage. Never allocates.
std::optional<HaplyState> parse_haply(std::string_view message) noexcept;

/// Over a link that is connected to the service. Throws Error when it does not answer with a device. `claimed`: kept as
/// long.
std::unique_ptr<HapticDevice> make_haply(std::unique_ptr<Link> link, const std::string& host, DeviceInfo identity,
                                         Descriptor claimed = {});

}  // namespace typodont::haptics
