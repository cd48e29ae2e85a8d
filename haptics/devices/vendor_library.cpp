#include "haptics/devices/vendor_library.h"

#include <dlfcn.h>

#include "engine/base/error.h"

namespace typodont::haptics {

VendorLibrary::VendorLibrary(std::initializer_list<const char*> names, const std::string& what_to_install) {
  std::string tried;
  for (const char* name : names) {
    handle_ = ::dlopen(name, RTLD_NOW | RTLD_LOCAL);
    if (handle_) {
      name_ = name;
      return;
    }
    tried += (tried.empty() ? "" : ", ") + std::string(name);
  }
  throw Error(tried, "", "not installed", what_to_install);
}

// The library is not closed, because threads of the vendor may still run in it.
VendorLibrary::~VendorLibrary() = default;

bool VendorLibrary::present(std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (void* handle = ::dlopen(name, RTLD_LAZY | RTLD_LOCAL)) {
      ::dlclose(handle);
      return true;
    }
  }
  return false;
}

void* VendorLibrary::symbol(const char* name, bool needed) const {
  void* address = ::dlsym(handle_, name);
  if (!address && needed) throw Error(name_, name, "no such function", "a version of the library that has it");
  return address;
}

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
