// HID through hidapi; without it, no devices, and Error on opening.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "haptics/devices/link.h"

namespace typodont::haptics {

struct HidNode {
  std::string path;  // path of the device node, /dev/hidrawN
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::uint16_t usage_page = 0;
  std::uint16_t usage = 0;
  int interface = -1;
  std::string maker, name, serial;
};

/// Also without permission. Not on the servo thread.
std::vector<HidNode> enumerate_hid();
/// Locked. Throws Error.
std::unique_ptr<Link> open_hid(const std::string& path);
/// Of a hidraw node in `sysfs` (hidapi 0.13 cannot); empty: none.
std::vector<std::uint8_t> report_descriptor(const std::string& path, const std::string& sysfs = "/sys");

}  // namespace typodont::haptics
