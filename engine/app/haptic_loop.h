// Runs servo, tissue update and hand of a scene on one thread, as fast as possible. Equal input gives equal output.
#pragma once

#include <functional>

#include "engine/app/scene.h"
#include "haptics/haptic_device.h"
#include "haptics/lockstep.h"

namespace typodont {

/// Creates the servo and the carver (which updates the tissue) for a session with this scene and hand. Both take turns
/// on one thread (LockStep). Takes ownership of the tissue. Throws Error.
haptics::LockStep lock_step_for(const Scene& scene, haptics::TissueVolume tissue, const haptics::DeviceInfo& hand);

class HapticLoop {
 public:
  /// Prepares the servo for this device. Takes ownership of the tissue.
  HapticLoop(const Scene& scene, haptics::TissueVolume tissue, const haptics::DeviceInfo& hand);
  /// Prepares the servo for a simulated hand, which is an ideal device with force and torque but without vibration.
  /// `rate`: rate of the servo, Hz.
  HapticLoop(const Scene& scene, haptics::TissueVolume tissue, double rate);

  /// Runs one tick of the servo, then the carver (which updates the tissue). If a new snapshot of the tissue is due,
  /// the next tick uses it. Returns true if the tick removed tissue.
  bool tick(const haptics::HandSample& hand, ServoTick& out, Cut& cut);

  /// Reads `hand` until it has no more samples. Calls `each` after every tick.
  void run(haptics::HapticDevice& hand, const std::function<void(const ServoTick&, const Cut* cut)>& each);

  /// Makes the tissue update (carver) stall once per second, each time for `seconds`. For tests of a late carver.
  void stall_carver(double seconds) { stall_ = seconds; }
  /// Makes the carver (which updates the tissue) stall (`held` true) or continue from the next tick on. Cuts made
  /// during a stall are applied after it.
  void hold_carver(bool held) { held_ = held; }

  haptics::Carver& carver() { return steps_.carver(); }
  haptics::Servo& servo() { return steps_.servo(); }
  /// Returns the snapshot of the tissue that the servo began to use before the last tick; null if the servo still uses
  /// the old snapshot.
  const PatchUse* fresh_patch() const { return steps_.fresh_snapshot(); }

 private:
  haptics::LockStep steps_;
  double stall_ = 0;  // s, duration of each stall of the carver that the loop simulates; 0: no stalls
  bool held_ = false;
};

}  // namespace typodont
