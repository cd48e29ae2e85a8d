// Bytes to and from a device; tests connect emulators.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "engine/base/clock.h"

namespace typodont::haptics {

/// HID: a report per call; serial and sockets: a stream. With its own clock, for simulated time.
class Link {
 public:
  virtual ~Link() = default;
  /// Up to `timeout` (ns): bytes read, 0: none, -1: lost. Servo thread.
  virtual int read(std::span<std::uint8_t> buffer, Nanos timeout) noexcept = 0;
  /// All bytes, one system call, no state: any thread or signal handler.
  virtual bool write(std::span<const std::uint8_t> bytes) noexcept = 0;
  virtual Nanos now() noexcept { return typodont::now(); }
  /// For a watchdog process (watchdog_process.h); -1: none.
  virtual int descriptor() const noexcept { return -1; }
};

/// Against unasked samples: none within half a period. Servo thread.
class SampleSpacing {
 public:
  /// `rate`: Hz, rate at which the device sends samples (DeviceInfo::rate).
  explicit SampleSpacing(double rate) : least_(from_seconds(0.5 / rate)) {}
  /// ns until the next may be used; 0 if the clock was set back.
  Nanos left(Nanos t) const noexcept { return started_ && t >= last_ ? last_ + least_ - t : 0; }
  /// Records that a sample was used at time t.
  void taken(Nanos t) noexcept { last_ = t, started_ = true; }

 private:
  Nanos least_, last_ = 0;
  bool started_ = false;
};
/// Messages per sample, so that a flood cannot delay a tick.
inline constexpr int kMostQueued = 64;

}  // namespace typodont::haptics
