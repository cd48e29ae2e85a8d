// A scene's haptic core on one thread, with its hand: same input, same bytes out; as fast as it can.
#pragma once

#include <functional>

#include "engine/app/scene.h"
#include "haptics/haptic_device.h"
#include "haptics/lockstep.h"

namespace typodont {

/// Servo and carver as a session of this scene has them, for this hand. The tissue is taken over. Throws Error.
haptics::LockStep lock_step_for(const Scene& scene, haptics::TissueVolume tissue, const haptics::DeviceInfo& hand);

class HapticLoop {
 public:
  /// The servo is set up for this hand, as a recording's header says it was (session_header). The tissue is taken over.
  HapticLoop(const Scene& scene, haptics::TissueVolume tissue, const haptics::DeviceInfo& hand);
  /// For a hand that follows force and torque at every step and feels no vibration: a simulated one. `rate` in Hz.
  HapticLoop(const Scene& scene, haptics::TissueVolume tissue, double rate);

  /// One tick: servo, then the carver, then, where due, a fresh snapshot before the next tick. True when it cut.
  bool tick(const haptics::HandSample& hand, ServoTick& out, Cut& cut);

  /// Reads `hand` to its end, calling `each` after every tick.
  void run(haptics::HapticDevice& hand, const std::function<void(const ServoTick&, const Cut* cut)>& each);

  /// For tests of what a late carver does to the hand: once a second it stands still for so long.
  void stall_carver(double seconds) { stall_ = seconds; }
  /// From the next tick on the carver stands still, or works again. Cuts made meanwhile wait for it.
  void hold_carver(bool held) { held_ = held; }

  haptics::Carver& carver() { return steps_.carver(); }
  /// The snapshot taken up before the last tick, when there was one.
  const PatchUse* fresh_patch() const { return steps_.fresh_snapshot(); }

 private:
  haptics::LockStep steps_;
  double stall_ = 0;  // s
  bool held_ = false;
};

}  // namespace typodont
