// Servo and carver in turn, on one thread: the haptic core without a clock. Same input, same bits; as fast as it can.
// The live program (engine/app/workbench.h) runs the same two on two threads.
#pragma once

#include <deque>
#include <memory>

#include "haptics/carver.h"
#include "haptics/servo.h"

namespace typodont::haptics {

/// tick() is the usual order of steps. A replay, whose recording dictates another order, calls the steps themselves.
/// Allocates: for tests, benches, scripts and tools, not for a real-time thread.
class LockStep {
 public:
  /// The tissue is taken over; `settings.frame` is set to its frame. Throws Error where the contact method refuses
  /// either.
  LockStep(TissueVolume tissue, ServoSettings settings);

  /// One tick: a fresh snapshot where one is due, the servo, then the carver. True, and `cut` filled, when tissue was
  /// removed.
  bool tick(const HandSample& hand, ServoTick& out, Cut& cut);

  /// While true, the carver stands still: cuts wait, and no snapshot is taken.
  void stall(bool stalled) { stalled_ = stalled; }

  // The steps by themselves.
  /// The carver repeats the waiting cuts up to this index.
  void apply_cuts(std::uint64_t through);
  /// The carver takes a snapshot around `center_W`, m.
  void take_snapshot(const dvec3& center_W, std::uint32_t number = 0) {
    carver_.take_snapshot(center_W, *spare_, number);
  }
  /// The servo takes it up.
  void adopt_snapshot();
  /// The servo alone; its cut waits for apply_cuts().
  bool tick_servo(const HandSample& hand, ServoTick& out, Cut& cut);

  Carver& carver() { return carver_; }
  const Carver& carver() const { return carver_; }
  Servo& servo() { return servo_; }
  const ServoSettings& settings() const { return settings_; }
  /// The snapshot taken up before the last tick, when there was one.
  const PatchUse* fresh_snapshot() const { return fresh_ ? &use_ : nullptr; }

 private:
  ServoSettings settings_;
  Carver carver_;
  Servo servo_;
  std::unique_ptr<Snapshot> spare_;
  std::deque<Cut> waiting_;  // made by the servo, not yet repeated by the carver
  ServoTick placed_;         // time and positions of hand and proxy in the last tick; nothing else is set
  std::uint64_t ticks_ = 0;
  bool stalled_ = false, fresh_ = false;
  PatchUse use_;
};

}  // namespace typodont::haptics
