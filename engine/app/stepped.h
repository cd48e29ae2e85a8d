// A session without a clock and threads: hand, servo and carver take turns, as fast as possible. Equal input gives
// equal output. Writes the same event logs as a live session.
#pragma once

#include <memory>
#include <optional>

#include "engine/app/event_logs.h"
#include "engine/app/scene.h"
#include "engine/app/sides.h"
#include "haptics/haptic_device.h"
#include "haptics/lockstep.h"

namespace typodont {

class SteppedSession {
 public:
  /// Prepares the servo for this hand. Throws Error.
  SteppedSession(const Scene& scene, haptics::TissueVolume tissue, const haptics::DeviceInfo& hand);
  /// Prepares the servo for a hand that can produce any torque and no vibration. `rate`: Hz.
  SteppedSession(const Scene& scene, haptics::TissueVolume tissue, double rate);
  SteppedSession(const SteppedSession&) = delete;
  SteppedSession& operator=(const SteppedSession&) = delete;

  /// The session's event logs. The first call creates them; earlier events are not in them.
  EventLogs& event_logs();

  /// Runs a tick of the servo, then the carver.
  const ServoTick& tick(const haptics::HandSample& hand);
  /// Runs a tick with the hand's next sample. Returns false after the hand's last sample; all cuts are then applied.
  bool advance(haptics::HapticDevice& hand);
  /// Undoes or redoes a stroke (cuts without a pause). False: no such stroke.
  bool edit(bool redo) { return edit_stroke(carver(), redo, tick_.t, event_logs_ ? &event_logs_->carver : nullptr); }

  /// The newest tick.
  const ServoTick& last() const { return tick_; }
  /// The cut of the newest tick, or null.
  const Cut* cut() const { return did_cut_ ? &cut_ : nullptr; }
  /// Number of pieces that have come loose so far.
  std::uint64_t pieces() const { return pieces_; }

  haptics::Carver& carver() { return steps_.carver(); }
  haptics::Servo& servo() { return steps_.servo(); }
  const haptics::ServoSettings& settings() const { return steps_.settings(); }

  /// While `held` is true, the carver waits.
  void hold_carver(bool held) { held_ = held; }
  /// The carver waits for this time (s) once per second, first after half a second.
  void stall_carver(double seconds) { stall_ = seconds; }
  /// Sets the computing time of all ticks to 0.
  void omit_times() { omits_times_ = true; }

 private:
  void write_pieces();

  haptics::LockStep steps_;
  const double rate_;                      // Hz, rate of the servo
  std::unique_ptr<EventLogs> event_logs_;  // null until event_logs() is called
  std::optional<ServoSide> side_;
  ServoTick tick_;
  Cut cut_;
  std::uint64_t pieces_ = 0;
  double stall_ = 0;  // s, time for which the carver waits once per second
  bool did_cut_ = false, held_ = false, omits_times_ = false;
};

}  // namespace typodont
