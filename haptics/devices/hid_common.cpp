#include <filesystem>
#include <fstream>
#include <iterator>

#include "haptics/devices/hid.h"

namespace typodont::haptics {

std::vector<std::uint8_t> report_descriptor(const std::string& path, const std::string& sysfs) {
  const std::filesystem::path node(path);
  std::ifstream in(std::filesystem::path(sysfs) / "class/hidraw" / node.filename() / "device/report_descriptor",
                   std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace typodont::haptics
