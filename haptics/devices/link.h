// Bytes to and from a device: the seam between protocols and hardware. Tests put their emulators behind it.
#pragma once

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

}  // namespace typodont::haptics
