// Hands for the program: open one by its address, list those that are there, add a kind. What lies in devices/ is
// private; device_safety.h, scripted_hand.h, udev_rules.h and device_bench.h are the rest of its interface.
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
  double rate = 1000;                 // Hz, where the program may choose it
  bool paced = true;                  // false: scripts run as fast as they can
  Pose X_WH;                          // the device's base in the workbench, from the rig
  Pose X_ST;                          // the tool's head as seen from the stylus
  std::vector<std::string> tools;     // what scripts may call the session's tools
  std::string pedal;                  // "", "auto", or a pedal's path or serial
  std::filesystem::path assets;       // where devices/*.json lie
  std::optional<double> force_limit;  // N; may only lower what the device states
  double pedal_limit = 0;             // s that the pedal may be held without a break; 0: what is usual
  /// Hands that live in a window or a headset ("mouse:", "openxr:right") are opened by the program while it has one: it
  /// gets the scheme and what follows the colon. Empty: there is no window, and their drivers say so.
  std::function<std::unique_ptr<HapticDevice>(const std::string& scheme, const std::string& rest)> window;
};

/// What `typodont devices` shows.
struct FoundDevice {
  std::string address;  // for --hand; empty for pedals
  std::string kind;     // "force feedback", "6-DoF mouse", "pedal", …
  std::string model, serial;
  std::string node;        // /dev/…, or the service
  double force_limit = 0;  // N
  bool permitted = true;
  std::string mend;  // the command or sentence that mends what is missing; empty when all is well
};

struct Driver {
  std::string scheme;    // "spacemouse": opens "spacemouse:REST"
  std::string rest;      // what REST is, for help: "[PATH]"
  std::string about;     // one line
  bool hardware = true;  // gets the safety layer, the pedal and the rig's base pose; its poses are in its base frame
  std::function<std::unique_ptr<HapticDevice>(const std::string& rest, const HandOptions&)> open;  // throws Error
  std::function<std::vector<FoundDevice>()> find;  // may be empty; never throws for what is merely absent
};

/// Every kind there is, in the order of their names; drivers of other modules (replay, mouse, OpenXR) are added at
/// set-up by the program.
const std::vector<Driver>& drivers();
void add_driver(Driver driver);

/// Opens --hand's address. Force-feedback devices come inside a SafeDevice. Throws Error.
std::unique_ptr<HapticDevice> open_hand(const std::string& address, const HandOptions& options);

/// The same for a session: hardware may be unplugged and plugged in again. Throws Error.
std::unique_ptr<HapticDevice> open_live_hand(const std::string& address, const HandOptions& options);

/// The hand with a foot pedal beside its own button; the one that is pressed further counts. `pedal` as
/// HandOptions::pedal; the hand alone where it is empty, or "auto" finds none. A pedal that is unplugged is looked for
/// again. open_hand() does this for hardware. Throws Error where the named pedal is not there.
std::unique_ptr<HapticDevice> add_pedal(std::unique_ptr<HapticDevice> hand, const std::string& pedal);

/// Everything that is plugged in, pedals included. Never throws for a device that is broken or forbidden: it is listed
/// with what mends it.
std::vector<FoundDevice> list_devices();

/// Hot-plugging: what came and went since the last look. Any one thread, a few times a second.
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
