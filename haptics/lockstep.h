// Servo and carver alternately on one thread: the haptic core without a clock, as fast as possible. Equal input gives
// equal bits. The live program (engine/app/workbench.h) runs both on two threads.
#pragma once

#include <deque>
#include <memory>

#include "haptics/carver.h"
#include "haptics/servo.h"

namespace typodont::haptics {

/// tick() runs the steps in the usual order. A replay, whose recording defines another order, calls the single steps.
/// Allocates memory: for tests, benches, scripts and tools, not for a real-time thread.
class LockStep {
 public:
  /// Takes the tissue over and sets `settings.frame` to its frame. Throws Error if the contact method rejects tissue or
  /// settings.
  LockStep(TissueVolume tissue, ServoSettings settings);

  /// One tick: a new snapshot if one is due, the servo, then the carver. Returns true and fills `cut` if the tissue
  /// changed.
  bool tick(const HandSample& hand, ServoTick& out, Cut& cut);

  /// While true, the carver does nothing: cuts wait, and no snapshot is taken.
  void stall(bool stalled) { stalled_ = stalled; }

  // Single steps of a run
  /// The carver repeats the waiting cuts up to this index.
  void apply_cuts(std::uint64_t through);
  /// The carver takes a snapshot around `center_W`, m.
  void take_snapshot(const dvec3& center_W, std::uint32_t number = 0) {
    carver_.take_snapshot(center_W, *spare_, number);
  }
  /// The servo adopts the snapshot that the carver took.
  void adopt_snapshot();
  /// Runs only the servo; its cut waits for apply_cuts().
  bool tick_servo(const HandSample& hand, ServoTick& out, Cut& cut);

  Carver& carver() { return carver_; }
  const Carver& carver() const { return carver_; }
  Servo& servo() { return servo_; }
  const ServoSettings& settings() const { return settings_; }
  /// The snapshot that was adopted before the last tick; null: none.
  const PatchUse* fresh_snapshot() const { return fresh_ ? &use_ : nullptr; }

 private:
  ServoSettings settings_;
  Carver carver_;
  Servo servo_;
  std::unique_ptr<Snapshot> spare_;
  std::deque<Cut> waiting_;  // cuts of the servo that the carver has not repeated yet
  ServoTick placed_;         // time and positions of hand and proxy in the last tick; other members are not set
  std::uint64_t ticks_ = 0;
  bool stalled_ = false, fresh_ = false;
  PatchUse use_;
};

}  // namespace typodont::haptics
