// The hands of a live session: which devices they are, how they are opened, and the loop of the second one.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/app/wiring.h"
#include "engine/contract/loop_timing.h"
#include "engine/display/display_rig.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// What was asked for, on the command line before the rig before what is usual.
struct HandChoice {
  std::string hand;                // address; empty: the rig's, else what is usual for the display
  std::string left_hand;           // address; empty: the rig's, else none
  std::string pedal;               // "auto", "none", a path or a serial; empty: the rig's, else auto
  double rate = 1000;              // Hz, of hands whose rate is ours to choose
  std::vector<std::string> tools;  // of the session, by name, for scripts
};

struct Hands {
  std::unique_ptr<haptics::HapticDevice> right;
  std::unique_ptr<haptics::HapticDevice> left;  // holds the mouth mirror; none: there is no second hand
};

/// Makes the hands that live in a window ("mouse", "") or a headset ("openxr", "right").
using WindowHands =
    std::function<std::unique_ptr<haptics::HapticDevice>(const std::string& scheme, const std::string& rest)>;

/// The hand's address, or `usual` where none was asked for. Throws Error when that is empty, too.
std::string hand_address(const HandChoice& choice, const display::DisplayRig* rig, const std::string& usual);
/// Opens them, at choice.hand. `window` makes those that live in a window or headset, or throws. Throws Error.
Hands open_hands(const HandChoice& choice, const display::DisplayRig* rig, const WindowHands& window);
/// Throws Error where one of them has motors and the system refuses SCHED_FIFO: a servo that other programs hold up
/// drives a motor with old forces. Set-up time, before the first force.
void require_real_time(const Hands& hands);
/// "Woody (1000 Hz, vibration up to 150 Hz)", for --explain.
std::string in_words(const haptics::DeviceInfo& info);

/// Registers mouse:, openxr: and expert: beside the built-in drivers, so that `typodont devices` and --hand know them.
void add_window_drivers();

/// Keeps what the recorder and the picture show of the loop. Servo thread; a tick costs some ten nanoseconds.
class LoopWatch {
 public:
  LoopWatch(Wiring& wiring, double rate) : wiring_(wiring) { report_.timing.period = from_seconds(1 / rate); }
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

/// The pedal as the servo sees it: up while the emergency key holds, and afterwards until it has been let go once.
/// Servo thread.
class PedalLock {
 public:
  double pass(double pedal, bool held) noexcept {
    locked_ = held || (locked_ && pedal >= 0.05);
    return locked_ ? 0 : pedal;
  }

 private:
  bool locked_ = false;
};

/// The emergency key, from the drawing thread: no drill, and force ramped to zero on every device with motors, until
/// the hands are let go on; then force comes back once they are free of contact.
void hold_hands(Wiring& wiring, bool hold) noexcept;

/// The second hand's thread: its pose is where the mouth mirror is. `mirror`: the scene's.
void left_hand_thread(Wiring& wiring, haptics::HapticDevice& hand, const MouthMirror& mirror, bool record);

}  // namespace typodont
