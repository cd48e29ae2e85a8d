// Runs servo and carver alternately on one thread, without a clock and as fast as possible. The result is
// deterministic. The live program (engine/app/workbench.h) runs them on two threads instead.
#pragma once

#include <deque>
#include <memory>

#include "haptics/carver.h"
#include "haptics/servo.h"

namespace typodont::haptics {

/// Servo and carver on one thread. tick() executes all steps of a tick in the usual order. A replay calls the single
/// steps itself, in the order of its recording. The class allocates memory, so use it for tests, benchmarks, scripts
/// and tools, not on a real-time thread.
class LockStep {
 public:
  /// Takes ownership of the tissue and sets `settings.frame` to its frame. Throws Error if the contact method rejects
  /// the tissue or the settings.
  LockStep(TissueVolume tissue, ServoSettings settings);

  /// Runs one tick: takes a new snapshot of the tissue if one is due, runs the servo, then lets the carver (owner of
  /// the tissue) repeat the cut. Returns true and sets `cut` if the tissue changed.
  bool tick(const HandSample& hand, ServoTick& out, Cut& cut);

  /// Simulates a carver thread that is late. While `stalled` is true, the carver does nothing: the servo's cuts wait
  /// for it, and it takes no snapshot of the tissue.
  void stall(bool stalled) { stalled_ = stalled; }

  // The following functions are the single steps of a tick.
  /// Lets the carver (owner of the tissue) repeat those waiting cuts whose index is at most `through`.
  void apply_cuts(std::uint64_t through);
  /// Lets the carver (owner of the tissue) take a snapshot of the tissue around `center_W` (m).
  void take_snapshot(const dvec3& center_W, std::uint32_t number = 0) {
    carver_.take_snapshot(center_W, *spare_, number, servo_.snapshot().number);
  }
  /// Lets the servo begin to use the snapshot that the carver took.
  void adopt_snapshot();
  /// Runs only the servo; its cut waits for apply_cuts().
  bool tick_servo(const HandSample& hand, ServoTick& out, Cut& cut);

  Carver& carver() { return carver_; }
  const Carver& carver() const { return carver_; }
  Servo& servo() { return servo_; }
  const ServoSettings& settings() const { return settings_; }
  /// Returns data about the snapshot that the servo adopted just before the last tick; null if it adopted none.
  const PatchUse* fresh_snapshot() const { return fresh_ ? &use_ : nullptr; }

 private:
  ServoSettings settings_;
  Carver carver_;
  Servo servo_;
  std::unique_ptr<Snapshot> spare_;
  std::deque<Cut> waiting_;  // cuts of the servo that the carver has not repeated yet
  ServoTick placed_;         // the last tick; only its time and the poses of hand and proxy are set
  std::uint64_t ticks_ = 0;
  bool stalled_ = false, fresh_ = false;
  PatchUse use_;
};

}  // namespace typodont::haptics
