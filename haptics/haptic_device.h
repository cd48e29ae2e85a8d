// Interface between a hand's device and the servo. Virtual, because hardware is exchangeable.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "engine/base/pose.h"
#include "haptics/servo.h"

namespace typodont::haptics {

struct DeviceInfo {
  std::string address;  // argument of --hand
  std::string model;
  std::string serial;
  double rate = 1000;           // Hz, rate of read()
  double force_limit = 0;       // N, largest force of the device; 0: the device gives no force
  double max_stiffness = 0;     // N/m; 0: unknown
  double torque_limit = 0;      // N·m, largest torque of the device; 0: the device gives no torque
  double continuous_force = 0;  // N, force that the motors can give continuously; 0: unknown
  double vibration_band = 0;    // Hz, limit of the vibration frequencies that the device renders; 0: none
  double silence = 0;           // s, time without a written force after which the watchdog sends zero; 0: the default
  double position_step = 0;     // m, resolution of the position: one encoder count; 0: smooth, or unknown
  // true: the pose is relative to the pose at opening, when the device must rest in its home position
  bool counts_from_rest = false;
};

/// State of the safety layer around a device with motors (devices/safe_device.h).
struct SafetyStatus {
  bool gives_force = false;   // the device has motors
  bool armed = false;         // force can reach the hand
  double heat = 0;            // 0..1, heat of the windings relative to their limit
  double bearable_force = 0;  // N, force that the windings can bear now
  std::uint32_t events = 0;   // SafetyEvent bits since the last call of safety()
};

/// A hand and the force on it: every device, simulated hand and script. Opened at set-up (throws Error), then owned by
/// the servo thread.
class HapticDevice {
 public:
  virtual ~HapticDevice() = default;
  virtual const DeviceInfo& info() const noexcept = 0;
  /// Waits for the next sample: this call is the servo's clock. Returns false if the device is lost or the script has
  /// ended.
  virtual bool read(HandSample& sample) noexcept = 0;
  /// Sets force and torque on the hand, W, N and N·m. They stay until the next call; the destructor sends zero.
  virtual void write(const dvec3& f_T_W, const dvec3& tau_T_W) noexcept = 0;
  /// Call before write(). The argument is true if the tool touches tissue, lies in tissue, or its contact is unknown,
  /// even if the force is zero. Motors that were released give no force until the argument has been false for some
  /// time. Servo thread.
  virtual void contact(bool) noexcept {}
  /// Call after write(), with the servo's answer to the last sample. Used by simulated hands that react to their tool,
  /// but not by hardware. Servo thread; never allocates.
  virtual void see(const ServoTick&) noexcept {}
  /// Fault bits of the last read(), for the tick that uses it.
  virtual std::uint32_t faults() const noexcept { return 0; }
  /// Joint angles of the last read(), rad, base first (the three bodies of an arm, then its stylus' three if it has
  /// encoders there); empty if the device does not report them. Servo thread; valid until the next read().
  virtual std::span<const double> joints() const noexcept { return {}; }
  /// State of the safety layer; empty for a device without motors. Servo thread.
  virtual SafetyStatus safety() noexcept { return {}; }
  /// Sends zero force now. Any thread, and signal handlers: never allocates, never locks, changes only the force.
  virtual void release() noexcept {}
};

}  // namespace typodont::haptics
