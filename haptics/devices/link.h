// Bytes to and from a device: the seam between protocols and hardware. Tests put their emulators behind it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "engine/base/clock.h"

namespace typodont::haptics {

/// A HID link carries whole reports, one per call; a serial port or socket carries a stream. A link brings its clock,
/// so that an emulated one can live in simulated time.
class Link {
 public:
  virtual ~Link() = default;
  /// Waits up to `timeout`. Bytes read, 0 when none came, -1 when the link is gone. Servo thread.
  virtual int read(std::span<std::uint8_t> buffer, Nanos timeout) noexcept = 0;
  /// All bytes or false. Any thread, also a signal handler: one system call, no state.
  virtual bool write(std::span<const std::uint8_t> bytes) noexcept = 0;
  virtual Nanos now() noexcept { return typodont::now(); }
  /// What stands behind it, for a keeper (keeper.h) that writes when this process no longer can; -1: nothing that
  /// could.
  virtual int descriptor() const noexcept { return -1; }
};

/// Keeps a device that sends without being asked from driving the servo faster than it was made for: two samples are at
/// least half a period apart. Servo thread.
class SampleSpacing {
 public:
  /// `rate` in Hz: DeviceInfo::rate.
  explicit SampleSpacing(double rate) : least_(from_seconds(0.5 / rate)) {}
  /// ns until the next sample may be handed over; 0 or less: now. A clock that was set back makes nobody wait.
  Nanos left(Nanos t) const noexcept { return started_ && t >= last_ ? last_ + least_ - t : 0; }
  /// A sample was handed over.
  void taken(Nanos t) noexcept { last_ = t, started_ = true; }

 private:
  Nanos least_, last_ = 0;
  bool started_ = false;
};
/// While more is queued than this, the rest waits for the next sample: a device that floods its link delays no tick.
inline constexpr int kMostQueued = 64;

}  // namespace typodont::haptics
