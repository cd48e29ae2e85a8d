// What stands between a hand and the servo: the only virtual interface of the haptics, because hardware is swapped.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "engine/base/pose.h"
#include "haptics/servo.h"

namespace typodont::haptics {

struct DeviceInfo {
  std::string address;  // as given to --hand
  std::string model;
  std::string serial;
  double rate = 1000;           // Hz, of read()
  double force_limit = 0;       // N; 0: the device gives no force
  double max_stiffness = 0;     // N/m; 0: unknown
  double torque_limit = 0;      // N·m; 0: the device gives no torque
  double continuous_force = 0;  // N that its motors bear for ever; 0: unknown
  double vibration_band = 0;    // Hz up to which it renders the spindle's vibration; 0: not at all
  double silence = 0;           // s without a force written, after which the watchdog sends zero; 0: what is usual
  double position_step = 0;  // m, the least that its position moves by: a count of its encoders; 0: smooth, or unknown
  bool counts_from_rest = false;  // its pose counts from where it was opened: its home position, and there it must rest
};

/// What the layer around a device with motors (devices/safe_device.h) has to say.
struct SafetyStatus {
  bool gives_force = false;   // it has motors
  bool armed = false;         // force may reach the hand
  double heat = 0;            // 0..1 of what the windings bear
  double bearable_force = 0;  // N that they may give now
  std::uint32_t events = 0;   // SafetyEvent bits since it was last asked
};

/// Opened at set-up (throws Error), then owned by the servo thread.
class HapticDevice {
 public:
  virtual ~HapticDevice() = default;
  virtual const DeviceInfo& info() const noexcept = 0;
  /// Waits for the next sample: this call is the servo's clock. False when the device is lost or the script has ended.
  virtual bool read(HandSample& sample) noexcept = 0;
  /// Force and torque on the hand, W, N and N·m. Held until the next call; the destructor sends zero.
  virtual void write(const dvec3& f_T_W, const dvec3& tau_T_W) noexcept = 0;
  /// Before write(): whether the tool touches tissue, or lies in it, or nobody knows, whatever the force. Motors that
  /// were let go give no force until that has been false for a while. Servo thread.
  virtual void contact(bool) noexcept {}
  /// After write(): the servo's answer to the last sample. Simulated hands that watch their tool use it; hardware does
  /// not. Servo thread; never allocates.
  virtual void see(const ServoTick&) noexcept {}
  /// Fault bits of the last read(), for the tick that uses it.
  virtual std::uint32_t faults() const noexcept { return 0; }
  /// Joint angles behind the sample of the last read(), rad, base first (an arm's three bodies, then its stylus' three
  /// where it has encoders there); empty where the device does not tell. Servo thread; valid until the next read().
  virtual std::span<const double> joints() const noexcept { return {}; }
  /// Servo thread. A device without motors has nothing to say.
  virtual SafetyStatus safety() noexcept { return {}; }
  /// Sends zero force now. Any thread, and signal handlers: never allocates, never locks, changes nothing but the
  /// force.
  virtual void release() noexcept {}
};

}  // namespace typodont::haptics
