// HID devices through hidapi; built without it, none is ever found and opening says so.
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

/// What is plugged in, whether or not it may be opened. Set-up time.
std::vector<HidNode> enumerate_hid();
/// Opens a node, locked against other programs. Throws Error.
std::unique_ptr<Link> open_hid(const std::string& path);
/// The report descriptor of a hidraw node, from `sysfs` (hidapi 0.13 has no call for it); empty when there is none.
std::vector<std::uint8_t> report_descriptor(const std::string& path, const std::string& sysfs = "/sys");

}  // namespace typodont::haptics
