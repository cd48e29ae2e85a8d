// Hands for the program: open a hand by its address, list connected devices, add a kind of device. The files in
// devices/ are private; device_safety.h, scripted_hand.h, udev_rules.h and device_bench.h are the rest of the
// interface.
//
// A new device is one file: devices/drivers/NAME.cpp that defines `const Driver NAME_driver` (see
// devices/drivers/circle.cpp). The build collects every file of that folder.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptics/haptic_device.h"

namespace typodont::haptics {

struct HandOptions {
  double rate = 1000;                 // Hz, rate for devices whose rate the program may choose
  bool paced = true;                  // false: scripts run as fast as possible
  Pose X_WH;                          // pose of the device's base in the workbench, from the rig
  Pose X_ST;                          // pose of the tool's head relative to the stylus
  std::vector<std::string> tools;     // names of the session's tools, as scripts may use them
  std::string pedal;                  // name of the pedal: "auto", its path or its serial number; empty: no pedal
  std::filesystem::path assets;       // folder that contains devices/*.json
  std::optional<double> force_limit;  // N, limit of the force; can only lower the device's own limit
  double pedal_limit = 0;  // s, limit of the time for which the pedal may be held without a break; 0: the default
  /// Opens hands that belong to a window or a headset ("mouse:", "openxr:right"). Arguments: the scheme, and the text
  /// after the colon. The program sets this function while it has a window. Empty: there is no window, and the
  /// drivers report this.
  std::function<std::unique_ptr<HapticDevice>(const std::string& scheme, const std::string& rest)> window;
};

/// One row of the output of `typodont devices`.
struct FoundDevice {
  std::string address;  // argument for --hand; empty for pedals
  std::string kind;     // "force feedback", "6-DoF mouse", "pedal", …
  std::string model, serial;
  std::string node;        // device node /dev/…, or name of the service
  double force_limit = 0;  // N
  bool permitted = true;
  std::string mend;  // command or sentence that says how to repair the problem; empty: no problem
};

struct Driver {
  std::string scheme;  // scheme of the address: "spacemouse" opens "spacemouse:REST"
  std::string rest;    // description of REST for help: "[PATH]"
  std::string about;   // description in one line
  // true: open_hand() adds the safety layer, the pedal and the rig's base pose; poses are in the device's base frame
  bool hardware = true;
  std::function<std::unique_ptr<HapticDevice>(const std::string& rest, const HandOptions&)> open;  // throws Error
  std::function<std::vector<FoundDevice>()> find;  // may be empty; does not throw if a device is absent
};

/// All drivers in the order of their names. At set-up, the program adds the drivers of other modules (replay, mouse,
/// OpenXR).
const std::vector<Driver>& drivers();
void add_driver(Driver driver);

/// Opens the hand with the address of --hand. Force-feedback devices are wrapped in a SafeDevice. Throws Error.
std::unique_ptr<HapticDevice> open_hand(const std::string& address, const HandOptions& options);

/// Opens a hand for a session. Hardware may be unplugged and plugged in again. Throws Error.
std::unique_ptr<HapticDevice> open_live_hand(const std::string& address, const HandOptions& options);

/// Adds a foot pedal to a hand; the larger of the values of pedal and button counts. `pedal`: see HandOptions::pedal.
/// Returns the hand alone if `pedal` is empty, or if "auto" finds no pedal. An unplugged pedal is searched for again.
/// open_hand() calls this for hardware. Throws Error if the named pedal does not exist.
std::unique_ptr<HapticDevice> add_pedal(std::unique_ptr<HapticDevice> hand, const std::string& pedal);

/// All connected devices, with pedals. Never throws for a broken or forbidden device: its row says how to repair the
/// problem.
std::vector<FoundDevice> list_devices();

/// Detects hot-plugging: look() returns the devices that were connected or removed since its last call. Any one
/// thread, a few times per second.
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

}  // namespace typodont::haptics
