// HID devices through hidapi. A build without hidapi finds no devices, and opening one throws an Error that says so.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "haptics/devices/link.h"

namespace typodont::haptics {

struct HidNode {
  std::string path;  // /dev/hidrawN
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::uint16_t usage_page = 0;
  std::uint16_t usage = 0;
  int interface = -1;
  std::string maker, name, serial;
};

/// Lists the connected devices, including those that this user may not open. Set-up time.
std::vector<HidNode> enumerate_hid();
/// Opens a node and locks it against other programs. Throws Error.
std::unique_ptr<Link> open_hid(const std::string& path);
/// Reads the report descriptor of a hidraw node from `sysfs` (hidapi 0.13 has no function for it). Returns an empty
/// vector if it does not exist.
std::vector<std::uint8_t> report_descriptor(const std::string& path, const std::string& sysfs = "/sys");

}  // namespace typodont::haptics
