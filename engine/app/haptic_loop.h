// The haptic core in one thread: hand, servo and carver in lock-step. Same input, same bytes out; as fast as it can.
// The live program (workbench.h) runs the same parts on two threads.
#pragma once

#include <deque>
#include <functional>

#include "engine/app/scene.h"
#include "haptics/carver.h"
#include "haptics/haptic_device.h"

namespace typodont {

class HapticLoop {
 public:
  /// `rate` in Hz. The tissue is taken over.
  HapticLoop(const Scene& scene, haptics::TissueVolume tissue, double rate);

  /// One tick: servo, then the carver, then, where due, a fresh patch before the next tick. Returns true when it cut.
  bool tick(const haptics::HandSample& hand, ServoTick& out, Cut& cut);

  /// Reads `hand` to its end, calling `each` after every tick.
  void run(haptics::HapticDevice& hand, const std::function<void(const ServoTick&, const Cut* cut)>& each);

  /// For tests of what a late carver does to the hand: once a second it stands still for so long.
  void stall_carver(double seconds) { stall_ = seconds; }
  /// From the next tick on the carver stands still, or works again. Cuts made meanwhile wait for it.
  void hold_carver(bool held) { held_ = held; }

  haptics::Carver& carver() { return carver_; }
  /// The patch taken up before the last tick, when there was one.
  const PatchUse* fresh_patch() const { return fresh_ ? &use_ : nullptr; }

 private:
  haptics::Carver carver_;
  haptics::Servo servo_;
  haptics::SurfacePatch spare_;
  ServoTick last_;
  std::uint64_t ticks_ = 0;
  double stall_ = 0;  // s
  bool held_ = false;
  std::deque<Cut> waiting_;  // made while the carver stood still
  bool fresh_ = false;
  PatchUse use_;
};

}  // namespace typodont
