// Transfers bytes to and from a device. Tests connect emulators to the same interface.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "engine/base/clock.h"

namespace typodont::haptics {

/// A HID link reads one report per call; serial and socket links read a stream. A link has its own clock, so that tests
/// can simulate time.
class Link {
 public:
  virtual ~Link() = default;
  /// Waits up to `timeout` (ns). Returns the number of bytes read, 0 for none, -1 if the device is lost. Servo thread
  /// only.
  virtual int read(std::span<std::uint8_t> buffer, Nanos timeout) noexcept = 0;
  /// Writes all bytes with one system call and no shared state. Any thread or signal handler.
  virtual bool write(std::span<const std::uint8_t> bytes) noexcept = 0;
  virtual Nanos now() noexcept { return typodont::now(); }
  /// Descriptor for a watchdog process (watchdog_process.h); -1: none.
  virtual int descriptor() const noexcept { return -1; }
};

/// Limits the sample rate of a device that sends unrequested samples: two samples are at least half a period apart.
/// Servo thread only.
class SampleSpacing {
 public:
  /// `rate`: Hz, rate at which the device sends samples (DeviceInfo::rate).
  explicit SampleSpacing(double rate) : least_(from_seconds(0.5 / rate)) {}
  /// Time until the next sample may be used, ns; 0 if the clock was set back.
  Nanos left(Nanos t) const noexcept { return started_ && t >= last_ ? last_ + least_ - t : 0; }
  /// Records that a sample was used at time t.
  void taken(Nanos t) noexcept { last_ = t, started_ = true; }

 private:
  Nanos least_, last_ = 0;
  bool started_ = false;
};
/// Largest number of queued messages read per sample, so that a flood of messages cannot delay a tick.
inline constexpr int kMaxQueued = 64;

}  // namespace typodont::haptics
