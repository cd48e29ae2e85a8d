// The interface Link: a connection that transfers bytes to and from a device. Protocols use it, and tests connect
// emulators to it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "engine/base/clock.h"

namespace typodont::haptics {

/// A connection to a device. A HID link transfers one complete report per call; a serial port or a socket transfers a
/// stream of bytes. A link has its own clock, so that an emulated link can use simulated time.
class Link {
 public:
  virtual ~Link() = default;
  /// Waits up to `timeout` (ns) for bytes. Returns their number, 0 if none arrived, or -1 if the connection is lost.
  /// Servo thread only.
  virtual int read(std::span<std::uint8_t> buffer, Nanos timeout) noexcept = 0;
  /// Writes all bytes; returns false if this fails. Any thread or signal handler may call it, because it has no state
  /// and makes one system call.
  virtual bool write(std::span<const std::uint8_t> bytes) noexcept = 0;
  virtual Nanos now() noexcept { return typodont::now(); }
  /// Returns the file descriptor of the link, or -1 if it has none. A watchdog process (watchdog_process.h) writes to
  /// it if this process cannot.
  virtual int descriptor() const noexcept { return -1; }
};

/// Limits the rate of samples from a device that sends samples without request. A sample that comes less than half a
/// period after the last used sample is not used. Servo thread only.
class SampleSpacing {
 public:
  /// `rate`: Hz, rate at which the device sends samples (DeviceInfo::rate).
  explicit SampleSpacing(double rate) : least_(from_seconds(0.5 / rate)) {}
  /// Returns the time in ns until the next sample may be used; 0 or less means now. If the clock was set back, the
  /// result is 0.
  Nanos left(Nanos t) const noexcept { return started_ && t >= last_ ? last_ + least_ - t : 0; }
  /// Records that a sample was used at time t.
  void taken(Nanos t) noexcept { last_ = t, started_ = true; }

 private:
  Nanos least_, last_ = 0;
  bool started_ = false;
};
/// Largest number of queued messages that are read for one sample. Further messages wait for the next sample, so that a
/// device that sends too many messages cannot delay a tick.
inline constexpr int kMostQueued = 64;

}  // namespace typodont::haptics
