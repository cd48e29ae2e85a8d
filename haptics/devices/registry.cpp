#include <unistd.h>

#include <algorithm>

#include "engine/base/error.h"
#include "engine/base/json.h"
#include "haptics/devices.h"
#include "haptics/devices/mounted_device.h"
#include "haptics/devices/pedal.h"
#include "haptics/devices/reconnecting.h"
#include "haptics/devices/safe_device.h"

namespace typodont::haptics {

/// Drivers of the folder drivers/; the build generates this function.
std::vector<Driver> built_in_drivers();

namespace {

std::vector<Driver>& table() {
  static std::vector<Driver> drivers = built_in_drivers();
  return drivers;
}

class MountedDevice : public HapticDevice {
 public:
  MountedDevice(std::unique_ptr<HapticDevice> device, const Pose& X_WH, const Pose& X_ST)
      : device_(std::move(device)), X_WH_(X_WH), X_ST_(X_ST) {}
  const DeviceInfo& info() const noexcept override { return device_->info(); }
  bool read(HandSample& sample) noexcept override {
    if (!device_->read(sample)) return false;
    R_WS_ = X_WH_.R * sample.X_WT.R;
    sample.X_WT = X_WH_ * sample.X_WT * X_ST_;
    return true;
  }
  void write(const dvec3& f_T_W, const dvec3& tau_T_W) noexcept override {
    const dvec3 p_ST_W = R_WS_ * X_ST_.p;
    const dquat R_HW = glm::conjugate(X_WH_.R);
    device_->write(R_HW * f_T_W, R_HW * (tau_T_W + glm::cross(p_ST_W, f_T_W)));
  }
  void contact(bool touching) noexcept override { device_->contact(touching); }
  std::uint32_t faults() const noexcept override { return device_->faults(); }
  std::span<const double> joints() const noexcept override { return device_->joints(); }
  SafetyStatus safety() noexcept override { return device_->safety(); }
  void release() noexcept override { device_->release(); }

 private:
  std::unique_ptr<HapticDevice> device_;
  Pose X_WH_, X_ST_;
  dquat R_WS_{1, 0, 0, 0};
};

std::string known_addresses() {
  std::string text;
  for (const Driver& driver : drivers()) {
    text += (text.empty() ? "" : ", ") + driver.scheme + ":" + driver.rest;
  }
  return text;
}

}  // namespace

const std::vector<Driver>& drivers() {
  return table();
}

void add_driver(Driver driver) {
  const auto at = std::lower_bound(table().begin(), table().end(), driver.scheme,
                                   [](const Driver& d, const std::string& scheme) { return d.scheme < scheme; });
  if (at != table().end() && at->scheme == driver.scheme) {
    *at = std::move(driver);
  } else {
    table().insert(at, std::move(driver));
  }
}

std::unique_ptr<HapticDevice> mount(std::unique_ptr<HapticDevice> device, const Pose& X_WH, const Pose& X_ST) {
  return std::make_unique<MountedDevice>(std::move(device), X_WH, X_ST);
}

std::unique_ptr<HapticDevice> add_pedal(std::unique_ptr<HapticDevice> hand, const std::string& pedal) {
  if (pedal.empty()) return hand;
  auto foot = open_pedal(pedal);
  if (!foot) return hand;
  return with_pedal(std::move(hand), std::move(foot), [pedal] { return open_pedal(pedal); });
}

std::unique_ptr<HapticDevice> open_hand(const std::string& address, const HandOptions& options) {
  const std::size_t colon = address.find(':');
  const std::string scheme = address.substr(0, colon);
  const auto driver = std::find_if(drivers().begin(), drivers().end(),
                                   [&](const Driver& d) { return colon != std::string::npos && d.scheme == scheme; });
  if (driver == drivers().end()) throw Error("--hand", "", address, known_addresses());
  std::unique_ptr<HapticDevice> device = driver->open(address.substr(colon + 1), options);
  if (!driver->hardware) return device;

  device = add_pedal(std::move(device), options.pedal);
  SafeDevice::Options safety = SafeDevice::options_for(device->info());
  if (options.force_limit) safety.limits.force = std::min(safety.limits.force, *options.force_limit);
  if (options.pedal_limit > 0) safety.limits.pedal_time = options.pedal_limit;
  device = std::make_unique<SafeDevice>(std::move(device), std::move(safety));
  return mount(std::move(device), options.X_WH, options.X_ST);
}

std::unique_ptr<HapticDevice> open_live_hand(const std::string& address, const HandOptions& options) {
  auto first = open_hand(address, options);
  const std::string scheme = address.substr(0, address.find(':'));
  for (const Driver& driver : drivers()) {
    if (driver.scheme != scheme || !driver.hardware) continue;
    auto open = [address, options] { return open_hand(address, options); };
    return std::make_unique<ReconnectingDevice>(std::move(first), std::move(open), ReconnectingDevice::Options{});
  }
  return first;
}

std::vector<FoundDevice> list_devices() {
  std::vector<FoundDevice> found;
  const auto add = [&](const std::string& kind, const auto& find) {
    try {
      for (FoundDevice& device : find()) found.push_back(std::move(device));
    } catch (const std::exception& e) {  // one driver must not hide the others
      found.push_back({"", kind, "cannot be looked for", "", "", 0, false, e.what()});
    }
  };
  for (const Driver& driver : drivers()) {
    if (driver.find) add(driver.scheme, driver.find);
  }
  add("pedal", find_pedals);
  return found;
}

std::vector<DeviceWatch::Change> DeviceWatch::look() {
  std::vector<FoundDevice> now = list_();
  const auto same = [](const FoundDevice& a, const FoundDevice& b) {
    return a.node == b.node && a.serial == b.serial && a.model == b.model && a.permitted == b.permitted;
  };
  const auto in = [&](const std::vector<FoundDevice>& list, const FoundDevice& device) {
    return std::any_of(list.begin(), list.end(), [&](const FoundDevice& other) { return same(device, other); });
  };
  std::vector<Change> changes;
  for (const FoundDevice& device : known_) {
    if (!in(now, device)) changes.push_back({false, device});
  }
  for (const FoundDevice& device : now) {
    if (!in(known_, device)) changes.push_back({true, device});
  }
  known_ = std::move(now);
  return changes;
}

std::filesystem::path install_udev_rules(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "70-typodont.rules";
  std::error_code none;
  if (!std::filesystem::is_directory(folder, none)) {
    throw Error(folder.string(), "", "no such folder", "the folder of udev's rules");
  }
  if (::access(folder.c_str(), W_OK) != 0) {
    throw Error(file.string(), "", "no permission to write it", "root; run: sudo typodont devices --install-udev");
  }
  write_file_atomically(file, udev_rules());
  return file;
}

}  // namespace typodont::haptics
