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
#include "haptics/haptic_device.h"

namespace typodont {

/// The requested hands. The command line has priority over the rig, and the rig over the defaults.
struct HandChoice {
  std::string hand;       // address of the hand; empty: the rig's value, otherwise the display's default
  std::string left_hand;  // address of the second hand; empty: the rig's value, otherwise no second hand
  std::string pedal;      // "auto", "none", a path or a serial number; empty: the rig's value, otherwise "auto"
  double rate = 1000;     // Hz, servo rate for hands without a fixed rate
  std::vector<std::string> tools;  // names of the session's tools, which a script may use
};

struct Hands {
  std::unique_ptr<haptics::HapticDevice> right;
  std::unique_ptr<haptics::HapticDevice> left;  // device that holds mouth mirror or suction; null: no second hand
};

/// Creates a hand that belongs to a window or a headset, from the scheme and the rest of an address, for example
/// "mouse" and "", or "openxr" and "right".
using WindowHands =
    std::function<std::unique_ptr<haptics::HapticDevice>(const std::string& scheme, const std::string& rest)>;

/// The hand's address, or `usual` if none was given. Throws Error if `usual` is empty, too.
std::string hand_address(const HandChoice& choice, const display::DisplayRig* rig, const std::string& usual);
/// Opens the hands for `choice`. `window` creates the hands that belong to a window or headset, or throws. Throws
/// Error.
Hands open_hands(const HandChoice& choice, const display::DisplayRig* rig, const WindowHands& window);
/// Throws Error if a device with motors is used and the system refuses SCHED_FIFO: other programs could then delay
/// the servo, and the motors would continue with old forces. Set-up time, before the first force.
void require_real_time(const Hands& hands);
/// Describes a device for --explain, for example "Woody (1000 Hz, vibration up to 150 Hz)".
std::string in_words(const haptics::DeviceInfo& info);

/// Registers mouse:, openxr: and expert: beside the built-in drivers, for `typodont devices` and --hand.
void add_window_drivers();

/// Collects the loop's statistics for the recorder and the picture. Servo thread; costs about ten nanoseconds per tick.
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

/// Filters the pedal. It counts as released during an emergency stop; after the stop, until the user has released it
/// once. Servo thread.
class PedalInterlock {
 public:
  double pass(double pedal, bool held) noexcept {
    locked_ = held || (locked_ && pedal >= 0.05);
    return locked_ ? 0 : pedal;
  }

 private:
  bool locked_ = false;
};

/// Switches the emergency stop on or off; called by the drawing thread. While it is on, the drill stops and the force
/// on every device with motors ramps down to zero. After it is switched off, the force returns once the hands are free
/// of contact.
void set_emergency_stop(Wiring& wiring, bool hold) noexcept;

/// The loop of the second hand's thread. This hand holds the mouth mirror or, if hand_holds_suction(scene), the suction
/// tip.
void left_hand_thread(Wiring& wiring, haptics::HapticDevice& hand, const Scene& scene, bool record);

}  // namespace typodont
