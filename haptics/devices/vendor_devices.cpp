#include "haptics/devices/vendor_devices.h"

namespace typodont::haptics {

std::vector<FoundDevice> VendorDevices::list(std::vector<FoundDevice> plain,
                                             const std::function<FoundDevice(std::size_t)>& ask) {
  const std::lock_guard lock(mutex_);
  if (plain.size() != plugged_in_ && in_use_ == 0) known_.clear();
  plugged_in_ = plain.size();
  for (std::size_t i = 0; i < plain.size(); ++i) {
    FoundDevice& device = plain[i];
    const auto known = known_.find(device.address);
    if (known != known_.end()) {
      device = known->second;
    } else if (in_use_ == 0) {
      device = ask(i);
      if (device.permitted) known_.emplace(device.address, device);
    }
  }
  return plain;
}

VendorDevices::Use::Use(VendorDevices& devices) : devices_(devices) {
  const std::lock_guard lock(devices_.mutex_);
  ++devices_.in_use_;
}

VendorDevices::Use::~Use() {
  const std::lock_guard lock(devices_.mutex_);
  --devices_.in_use_;
}

void VendorDevices::Use::is(const FoundDevice& device) {
  const std::lock_guard lock(devices_.mutex_);
  devices_.known_[device.address] = device;
}

}  // namespace typodont::haptics
