// Runs servo (force) and carver (removes tissue) alternately on one thread, without a clock, so that the result is
// deterministic. In a live session, each has its own thread (engine/app/workbench.h).
#pragma once

#include <deque>
#include <memory>

#include "haptics/carver.h"
#include "haptics/servo.h"

namespace typodont::haptics {

/// tick() does all steps of a tick; a replay calls the single steps in the order of its recording. Allocates memory, so
/// not for a real-time thread.
class LockStep {
 public:
  /// Takes over the tissue, and sets `settings.frame`. Throws Error if the contact method rejects tissue or settings.
  LockStep(TissueVolume tissue, ServoSettings settings);

  /// Takes a snapshot if one is due, computes the servo's tick, and applies its cut. Returns true and sets `cut` if the
  /// tissue changed.
  bool tick(const HandSample& hand, ServoTick& out, Cut& cut);

  /// Simulates a late carver: while true, cuts wait and no snapshot is taken.
  void stall(bool stalled) { stalled_ = stalled; }

  // Single steps of a tick.
  /// Applies the waiting cuts up to the cut with index `through`.
  void apply_cuts(std::uint64_t through);
  /// Takes a snapshot around `center_W`, m.
  void take_snapshot(const dvec3& center_W, std::uint32_t number = 0) {
    carver_.take_snapshot(center_W, *spare_, number, servo_.snapshot().number);
  }
  /// Passes the carver's snapshot to the servo.
  void adopt_snapshot();
  /// Computes a servo tick; its cut waits for apply_cuts().
  bool tick_servo(const HandSample& hand, ServoTick& out, Cut& cut);

  Carver& carver() { return carver_; }
  const Carver& carver() const { return carver_; }
  Servo& servo() { return servo_; }
  const ServoSettings& settings() const { return settings_; }
  /// Returns the snapshot that was adopted just before the last tick; null: none.
  const PatchUse* fresh_snapshot() const { return fresh_ ? &use_ : nullptr; }

 private:
  /// Applies the waiting cuts. Stops at an undo, a redo or a loose piece, of which the servo must first get a snapshot.
  void follow_servo();

  ServoSettings settings_;
  Carver carver_;
  Servo servo_;
  std::unique_ptr<Snapshot> spare_;
  std::deque<Cut> waiting_;  // cuts that the carver has not applied yet
  ServoTick placed_;         // last tick, of which only time and the positions of hand and proxy are stored
  std::uint64_t ticks_ = 0;
  bool stalled_ = false, fresh_ = false;
  PatchUse use_;
};

}  // namespace typodont::haptics
