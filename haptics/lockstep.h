// Servo and carver in turn on one thread, without a clock, deterministic. Live, they have two threads
// (engine/app/workbench.h).
#pragma once

#include <deque>
#include <memory>

#include "haptics/carver.h"
#include "haptics/servo.h"

namespace typodont::haptics {

/// tick() is all of a tick; a replay calls the steps in its recording's order. Allocates: not for a real-time thread.
class LockStep {
 public:
  /// Takes the tissue and sets `settings.frame`. Throws Error if the method rejects tissue or settings.
  LockStep(TissueVolume tissue, ServoSettings settings);

  /// Snapshot if due, servo, then the carver's cut. True, with `cut`: the tissue changed.
  bool tick(const HandSample& hand, ServoTick& out, Cut& cut);

  /// A late carver: cuts wait, and no snapshot is taken.
  void stall(bool stalled) { stalled_ = stalled; }

  // Single steps of a tick.
  /// Waiting cuts up to index `through`.
  void apply_cuts(std::uint64_t through);
  /// Around `center_W` (m).
  void take_snapshot(const dvec3& center_W, std::uint32_t number = 0) {
    carver_.take_snapshot(center_W, *spare_, number, servo_.snapshot().number);
  }
  /// The carver's snapshot to the servo.
  void adopt_snapshot();
  /// The cut waits for apply_cuts().
  bool tick_servo(const HandSample& hand, ServoTick& out, Cut& cut);

  Carver& carver() { return carver_; }
  const Carver& carver() const { return carver_; }
  Servo& servo() { return servo_; }
  const ServoSettings& settings() const { return settings_; }
  /// Adopted just before the last tick; null: none.
  const PatchUse* fresh_snapshot() const { return fresh_ ? &use_ : nullptr; }

 private:
  /// Waiting cuts up to an edit, which the servo adopts first.
  void follow_servo();

  ServoSettings settings_;
  Carver carver_;
  Servo servo_;
  std::unique_ptr<Snapshot> spare_;
  std::deque<Cut> waiting_;  // not yet repeated by the carver
  ServoTick placed_;         // only time and poses of hand and proxy
  std::uint64_t ticks_ = 0;
  bool stalled_ = false, fresh_ = false;
  PatchUse use_;
};

}  // namespace typodont::haptics
