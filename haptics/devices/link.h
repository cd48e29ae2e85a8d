// A connection to a device that transfers bytes: the interface between protocols and hardware. Tests connect emulators
// to it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "engine/base/clock.h"

namespace typodont::haptics {

/// A HID link transfers complete reports, one per call; a serial port or socket transfers a stream. A link has a clock,
/// so that an emulated link can use simulated time.
class Link {
 public:
  virtual ~Link() = default;
  /// Waits up to `timeout`. Returns the number of bytes; 0 if no bytes arrived, -1 if the link is lost. Servo thread.
  virtual int read(std::span<std::uint8_t> buffer, Nanos timeout) noexcept = 0;
  /// Writes all bytes or returns false. Any thread or signal handler, because it makes a single system call and has
  /// no state.
  virtual bool write(std::span<const std::uint8_t> bytes) noexcept = 0;
  virtual Nanos now() noexcept { return typodont::now(); }
  /// The file descriptor, for a watchdog process (watchdog_process.h) that writes when this process cannot; -1: none.
  virtual int descriptor() const noexcept { return -1; }
};

/// Limits the rate of a device that sends samples without request: two used samples are at least half a period apart.
/// Servo thread.
class SampleSpacing {
 public:
  /// `rate` in Hz: DeviceInfo::rate.
  explicit SampleSpacing(double rate) : least_(from_seconds(0.5 / rate)) {}
  /// Time until the next sample may be used, ns; 0 or less: now. If the clock was set back, there is no wait.
  Nanos left(Nanos t) const noexcept { return started_ && t >= last_ ? last_ + least_ - t : 0; }
  /// Records that a sample was used.
  void taken(Nanos t) noexcept { last_ = t, started_ = true; }

 private:
  Nanos least_, last_ = 0;
  bool started_ = false;
};
/// Largest number of queued messages that are processed at once. The remaining messages wait for the next sample, so
/// that a device that floods its link does not delay a tick.
inline constexpr int kMostQueued = 64;

}  // namespace typodont::haptics
