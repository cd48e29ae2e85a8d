#include "engine/base/error.h"
#include "haptics/devices/hid.h"

namespace typodont::haptics {

std::vector<HidNode> enumerate_hid() {
  return {};
}

std::unique_ptr<Link> open_hid(const std::string& path) {
  throw Error(path, "", "a program built without hidapi", "one configured with TYPODONT_HIDAPI=ON");
}

}  // namespace typodont::haptics
