// Accesses HID devices through the library hidapi. A build without hidapi finds no devices, and opening a device throws
// an Error that states this.
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

/// Lists the connected devices, also those that this user may not open. Not for the servo thread.
std::vector<HidNode> enumerate_hid();
/// Opens a device node and locks it against other programs. Throws Error.
std::unique_ptr<Link> open_hid(const std::string& path);
/// Reads the report descriptor of a hidraw node from the folder `sysfs`, because hidapi 0.13 has no function for it.
/// Returns an empty vector if there is none.
std::vector<std::uint8_t> report_descriptor(const std::string& path, const std::string& sysfs = "/sys");

}  // namespace typodont::haptics
