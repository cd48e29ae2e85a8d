// Opens a hand (haptic device or scripted motion) by its address, lists devices, registers drivers. Other modules
// include only this header, device_safety.h, scripted_hand.h and device_bench.h. To add a device, write a file
// devices/drivers/NAME.cpp that defines `const Driver NAME_driver`.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/arm_geometry.h"
#include "haptics/haptic_device.h"

namespace typodont::haptics {

struct HandOptions {
  double rate = 1000;              // Hz, sample rate, if the driver lets it be chosen
  bool paced = true;               // a scripted hand waits for each sample's time; false: it runs as fast as possible
  Pose X_WH;                       // pose of the device's base on the workbench, from the rig file
  Pose X_ST;                       // pose of the tool's head in the stylus
  std::optional<ArmGeometry> arm;  // measured geometry of a serial arm, from the rig file; empty: its preset's
  std::vector<std::string> tools;  // names of the session's tools, for scripts
  std::string pedal;               // "auto", device path or serial number; empty: none
  std::filesystem::path assets;    // folder that contains devices/*.json
  std::optional<double> force_limit;  // N, force limit; may only reduce the device's own limit
  double pedal_limit = 0;             // s, largest time that the pedal may be pressed without a break; 0: default
  /// Opens "mouse:" and "openxr:right" while the program has a window; empty: their drivers throw Error. Arguments:
  /// text before and after the colon.
  std::function<std::unique_ptr<HapticDevice>(const std::string& scheme, const std::string& rest)> window;
};

/// One line of the output of `typodont devices`.
struct FoundDevice {
  std::string address;  // address for --hand; empty for pedals
  std::string kind;     // "force feedback", "6-DoF mouse", "pedal", …
  std::string model, serial;
  std::string node;        // device node, such as /dev/hidraw0, or a service
  double force_limit = 0;  // N, largest force of the device
  bool permitted = true;
  std::string mend;  // how to repair a problem; empty: no problem
};

struct Driver {
  std::string scheme;  // text before the colon in the address: "spacemouse" in "spacemouse:REST"
  std::string rest;    // text after the colon in the address, for the help: "[PATH]"
  std::string about;   // description of the device in one line
  // true: a device with poses in its base's frame. open_hand() then adds safety layer, pedal and pose of the base.
  bool hardware = true;
  // opens the device; `rest`: text after the colon in its address; throws Error
  std::function<std::unique_ptr<HapticDevice>(const std::string& rest, const HandOptions&)> open;
  // Finds connected devices; may be empty. Must not throw if a device is absent.
  std::function<std::vector<FoundDevice>()> find;
};

/// Drivers, sorted by name. The program adds replay, mouse and OpenXR at set-up.
const std::vector<Driver>& drivers();
void add_driver(Driver driver);

/// Opens a hand by its address (option --hand). Devices with motors get a SafeDevice. Throws Error.
std::unique_ptr<HapticDevice> open_hand(const std::string& address, const HandOptions& options);

/// Opens a hand that may be unplugged and plugged in again during a session. Throws Error.
std::unique_ptr<HapticDevice> open_live_hand(const std::string& address, const HandOptions& options);

/// Adds a foot pedal to a hand, as open_hand() does for hardware. The pedal is the larger of foot pedal and button. If
/// `pedal` is empty, or "auto" finds none, returns the hand alone. Throws Error if a named pedal is missing.
std::unique_ptr<HapticDevice> add_pedal(std::unique_ptr<HapticDevice> hand, const std::string& pedal);

/// Lists devices and pedals. Broken devices and missing permissions do not throw: see FoundDevice::mend.
std::vector<FoundDevice> list_devices();

/// Reports devices that arrived or left since the last call of look(). For one thread, which calls it a few times per
/// second.
class DeviceWatch {
 public:
  struct Change {
    bool arrived;
    FoundDevice device;
  };
  explicit DeviceWatch(std::function<std::vector<FoundDevice>()> list = list_devices) : list_(std::move(list)) {}
  std::vector<Change> look();

 private:
  std::function<std::vector<FoundDevice>()> list_;
  std::vector<FoundDevice> known_;
};

std::string_view udev_rules();

/// Writes the udev rules into `folder`, completely or not at all; returns their path. Without permission, throws Error
/// with the command to run.
std::filesystem::path install_udev_rules(const std::filesystem::path& folder);

}  // namespace typodont::haptics
