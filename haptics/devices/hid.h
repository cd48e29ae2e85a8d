// Access to HID devices through hidapi. In a build without hidapi, there are no devices, and opening one throws
// Error.
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

/// Lists all HID devices, also those without access permission. Not for the servo thread.
std::vector<HidNode> enumerate_hid();
/// Opens a device and locks it. Throws Error.
std::unique_ptr<Link> open_hid(const std::string& path);
/// Report descriptor of a hidraw node, read from `sysfs` because hidapi 0.13 cannot read it; empty: none.
std::vector<std::uint8_t> report_descriptor(const std::string& path, const std::string& sysfs = "/sys");

}  // namespace typodont::haptics
