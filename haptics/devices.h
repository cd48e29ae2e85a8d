// Opens a hand by its address, lists connected devices, and adds drivers. Other modules may include this header,
// device_safety.h, scripted_hand.h, udev_rules.h and device_bench.h, but not the files in devices/. To add a device,
// add one file devices/drivers/NAME.cpp that defines `const Driver NAME_driver` (see devices/drivers/circle.cpp). The
// build compiles every file of that folder.
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
  double rate = 1000;  // Hz, rate of devices whose rate can be chosen
  bool paced = true;   // true: scripted hands wait for the time of each sample; false: they run as fast as possible
  Pose X_WH;           // pose of the device's base in the workbench frame, from the rig file
  Pose X_ST;           // pose of the tool's head relative to the stylus
  std::vector<std::string> tools;     // names of the session's tools, for use in scripts
  std::string pedal;                  // pedal to use: "auto", a device path or a serial number; empty: no pedal
  std::filesystem::path assets;       // folder that contains devices/*.json
  std::optional<double> force_limit;  // N, additional force limit; it can only lower the device's own limit
  double pedal_limit = 0;  // s, the pedal may be pressed without a break for at most this time; 0: the default time
  /// Function that opens the hands of a window or a headset (addresses "mouse:", "openxr:right"). Its arguments are the
  /// parts of the address before and after the colon. The program sets the function while it has a window. Without a
  /// window, the function is empty, and the drivers report an error.
  std::function<std::unique_ptr<HapticDevice>(const std::string& scheme, const std::string& rest)> window;
};

/// One line of the output of `typodont devices`.
struct FoundDevice {
  std::string address;  // address for --hand; empty for pedals
  std::string kind;     // kind of device: "force feedback", "6-DoF mouse", "pedal", …
  std::string model, serial;
  std::string node;        // device node, such as /dev/hidraw0, or name of the service
  double force_limit = 0;  // N, largest force of the device
  bool permitted = true;
  std::string mend;  // advice that tells the user how to repair a problem; empty: no problem
};

struct Driver {
  std::string scheme;  // scheme of the address; for example "spacemouse" opens "spacemouse:REST"
  std::string rest;    // description of the address after "scheme:", for the help text: "[PATH]"
  std::string about;   // description of the device in one line
  // true: the driver's poses are in the frame of the device's base. open_hand() adds the safety layer and the pedal,
  // and converts the poses with the pose of the base.
  bool hardware = true;
  // function that opens the hand; throws Error
  std::function<std::unique_ptr<HapticDevice>(const std::string& rest, const HandOptions&)> open;
  // finds connected devices; may be empty; must not throw if a device is absent
  std::function<std::vector<FoundDevice>()> find;
};

/// Returns all drivers in the order of their names. At set-up, the program adds the drivers of other modules (replay,
/// mouse, OpenXR).
const std::vector<Driver>& drivers();
void add_driver(Driver driver);

/// Opens the hand with an address as given to --hand. Devices with motors are wrapped in a SafeDevice. Throws Error.
std::unique_ptr<HapticDevice> open_hand(const std::string& address, const HandOptions& options);

/// Opens a hand for a session. A device may be unplugged and plugged in again during the session. Throws Error.
std::unique_ptr<HapticDevice> open_live_hand(const std::string& address, const HandOptions& options);

/// Adds a foot pedal to a hand. The resulting pedal value is the larger value of the foot pedal and the hand's button.
/// If a pedal was unplugged, the program searches for it again. `pedal`: see HandOptions::pedal. If `pedal` is empty,
/// or if "auto" finds no pedal, the function returns the hand alone. If a pedal is named that does not exist, the
/// function throws Error. open_hand() calls this function for hardware.
std::unique_ptr<HapticDevice> add_pedal(std::unique_ptr<HapticDevice> hand, const std::string& pedal);

/// Returns all connected devices, including pedals. If a device is broken or a permission is missing, throws nothing:
/// the entry of this device (FoundDevice::mend) then states how to repair the problem.
std::vector<FoundDevice> list_devices();

/// Detects when devices are connected or removed. look() returns the changes since the last call of look(). Only one
/// thread may call look(), a few times per second.
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
