// The hands of a live session: the choice of devices, how they are opened, and the loop of the second hand.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "engine/contract/loop_timing.h"
#include "engine/display/display_rig.h"
#include "engine/display/output.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// Devices that the user chose to move the tools. The command line overrides the rig file, which overrides the default.
struct HandChoice {
  /// Address of the hand's device. If empty: the address in the rig file, otherwise the display's default.
  std::string hand;
  /// Address of the second hand's device. If empty: the address in the rig file, otherwise there is no second hand.
  std::string left_hand;
  /// Foot pedal: "auto", "none", a path or a serial number. If empty: the pedal in the rig file, otherwise "auto".
  std::string pedal;
  double rate = 1000;              // Hz, servo rate if the hand has no fixed rate
  std::vector<std::string> tools;  // names of the session's tools, which a script may use
};

struct Hands {
  std::unique_ptr<haptics::HapticDevice> right;
  /// device that moves the mouth mirror or the suction tip; null if there is no second hand
  std::unique_ptr<haptics::HapticDevice> left;
};

/// Function that creates a hand whose motion comes from a window or a headset. Its two arguments are the parts of the
/// hand's address before and after the colon, for example "mouse" and "", or "openxr" and "right".
using WindowHands =
    std::function<std::unique_ptr<haptics::HapticDevice>(const std::string& scheme, const std::string& rest)>;

/// The address of the hand: the user's choice, otherwise that of the rig file, otherwise `usual`. Throws Error if all
/// three are empty.
std::string hand_address(const HandChoice& choice, const display::DisplayRig* rig, const std::string& usual);
/// Opens the hands of `choice`. `window`: function that creates the hands of a window or headset; it may throw. Throws
/// Error.
Hands open_hands(const HandChoice& choice, const display::DisplayRig* rig, const WindowHands& window);
/// Throws Error if a device has motors and the system refuses real-time scheduling (SCHED_FIFO), without which other
/// programs could delay the servo; the motors would then keep an old force. Call before the first force is sent.
void require_real_time(const Hands& hands);
/// Describes a device for the option --explain, for example "Woody (1000 Hz, vibration up to 150 Hz)".
std::string in_words(const haptics::DeviceInfo& info);

/// Makes the drivers mouse:, openxr: and expert: available, besides the built-in drivers, for `typodont devices` and
/// for the option --hand.
void add_window_drivers();

/// Collects statistics of the servo loop for the recorder and the picture. For the servo thread only; costs about ten
/// nanoseconds per tick.
class LoopStatistics {
 public:
  LoopStatistics(Wiring& wiring, double rate) : wiring_(wiring) { report_.timing.period = from_seconds(1 / rate); }
  void granted(bool fifo, bool pinned, bool memory_locked, std::string_view note) {
    report_.fifo = fifo, report_.pinned = pinned, report_.memory_locked = memory_locked;
    report_.say(note);
  }
  void tick(Nanos woke, Nanos done, const haptics::SafetyStatus& safety) noexcept;
  void publish() noexcept;
  const LoopReport& report() const { return report_; }

 private:
  Wiring& wiring_;
  LoopReport report_;
  Nanos published_ = 0;
};

/// Filters the pedal's state. During an emergency stop, the pedal counts as released, and also afterwards until the
/// user has released it once. Servo thread only.
class PedalInterlock {
 public:
  double pass(double pedal, bool held) noexcept {
    locked_ = held || (locked_ && pedal >= 0.05);
    return locked_ ? 0 : pedal;
  }

 private:
  bool locked_ = false;
};

/// Keys of the emergency stop: Space and Esc begin it, R ends it (haptics/device_safety.h). One thread handles all
/// three, so the last key counts.
display::UrgentKeys emergency_keys();

/// The function of the second hand's thread. The second hand moves the mouth mirror or, if hand_holds_suction(scene),
/// the suction tip. A sample from before the session has the time -1.
void left_hand_thread(Wiring& wiring, haptics::HapticDevice& hand);

}  // namespace typodont
