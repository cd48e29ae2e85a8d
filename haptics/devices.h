// Opens hands by address, lists devices, adds drivers. Beside this header, others may include device_safety.h,
// scripted_hand.h and device_bench.h, not devices/. A new device is one file devices/drivers/NAME.cpp
// with `const Driver NAME_driver` (example: circle.cpp); all are compiled.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

struct HandOptions {
  double rate = 1000;                 // Hz, where it can be chosen
  bool paced = true;                  // scripted hands wait for each sample's time; false: as fast as possible
  Pose X_WH;                          // of the device's base in W, from the rig file
  Pose X_ST;                          // tool's head in the stylus
  std::vector<std::string> tools;     // of the session's tools, for scripts
  std::string pedal;                  // "auto", device path or serial number; empty: none
  std::filesystem::path assets;       // folder that contains devices/*.json
  std::optional<double> force_limit;  // N; can only lower the device's own
  double pedal_limit = 0;             // s without a break; 0: default
  /// For "mouse:" and "openxr:right", set while the program has a window; empty: drivers report an error. Arguments:
  /// before and after the colon.
  std::function<std::unique_ptr<HapticDevice>(const std::string& scheme, const std::string& rest)> window;
};

/// One line of the output of `typodont devices`.
struct FoundDevice {
  std::string address;  // address for --hand; empty for pedals
  std::string kind;     // "force feedback", "6-DoF mouse", "pedal", …
  std::string model, serial;
  std::string node;        // such as /dev/hidraw0, or a service
  double force_limit = 0;  // N, largest force of the device
  bool permitted = true;
  std::string mend;  // how to repair; empty: no problem
};

struct Driver {
  std::string scheme;  // "spacemouse" opens "spacemouse:REST"
  std::string rest;    // after "scheme:", for the help: "[PATH]"
  std::string about;   // description of the device in one line
  // Poses are in the base's frame; open_hand() adds safety layer, pedal and the base's pose.
  bool hardware = true;
  // function that opens the hand; throws Error
  std::function<std::unique_ptr<HapticDevice>(const std::string& rest, const HandOptions&)> open;
  // may be empty; must not throw for an absent device
  std::function<std::vector<FoundDevice>()> find;
};

/// By name. At set-up, the program adds replay, mouse and OpenXR.
const std::vector<Driver>& drivers();
void add_driver(Driver driver);

/// As given to --hand. Motors get a SafeDevice. Throws Error.
std::unique_ptr<HapticDevice> open_hand(const std::string& address, const HandOptions& options);

/// For a session: may be unplugged and plugged in again. Throws Error.
std::unique_ptr<HapticDevice> open_live_hand(const std::string& address, const HandOptions& options);

/// The larger of foot pedal and button counts; an unplugged pedal is searched again. Empty `pedal`, or "auto" without
/// one: the hand alone. Throws Error if a named one is missing. open_hand() calls it for hardware.
std::unique_ptr<HapticDevice> add_pedal(std::unique_ptr<HapticDevice> hand, const std::string& pedal);

/// With pedals. Broken devices and missing permissions do not throw: see FoundDevice::mend.
std::vector<FoundDevice> list_devices();

/// look(): changes since its last call. One thread, a few times per second.
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

/// Into `folder`, completely or not at all; returns the path. Throws Error with the command to run, without permission.
std::filesystem::path install_udev_rules(const std::filesystem::path& folder);

}  // namespace typodont::haptics
