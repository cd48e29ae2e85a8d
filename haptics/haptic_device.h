// Interface between a hand's device and the servo. The functions are virtual, because a session can use different
// devices.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "engine/base/pose.h"
#include "haptics/servo.h"

namespace typodont::haptics {

struct DeviceInfo {
  std::string address;  // address as given to --hand
  std::string model;
  std::string serial;
  double rate = 1000;           // Hz, rate at which read() delivers samples
  double force_limit = 0;       // N, largest force of the device; 0: the device has no force output
  double max_stiffness = 0;     // N/m, largest stiffness of the device; 0: unknown
  double torque_limit = 0;      // N·m, largest torque of the device; 0: the device has no torque output
  double continuous_force = 0;  // N, force that the motors can sustain; 0: unknown
  double vibration_band = 0;    // Hz, highest vibration frequency that the device can output; 0: none
  // s, watchdog time: if no force is written for this time, the force is set to zero; 0: the default time
  double silence = 0;
  double position_step = 0;  // m, resolution of the position (one encoder count); 0: no steps, or unknown
  // true: poses are relative to the device's pose when it was opened; the device must then be in its home position
  bool counts_from_rest = false;
};

/// State of the safety layer of a device with motors (devices/safe_device.h).
struct SafetyStatus {
  bool gives_force = false;   // the device has motors
  bool armed = false;         // true: the safety layer passes forces to the hand
  double heat = 0;            // heat of the motor windings relative to their limit, 0..1
  double bearable_force = 0;  // N, force that the windings can sustain at their present heat
  std::uint32_t events = 0;   // SafetyEvent bits that occurred since the last call of safety()
};

/// A hand, and the force on it: a haptic device, a simulated hand or a script. Opened at set-up (throws Error), then
/// owned by the servo thread.
class HapticDevice {
 public:
  virtual ~HapticDevice() = default;
  virtual const DeviceInfo& info() const noexcept = 0;
  /// Waits for the next sample; this call determines the timing of the servo. Returns false if the device is lost or
  /// the script has ended.
  virtual bool read(HandSample& sample) noexcept = 0;
  /// Sets force (N) and torque (N·m) on the hand, in the workbench frame W. They stay constant until the next call. The
  /// destructor sends zero force.
  virtual void write(const dvec3& f_T_W, const dvec3& tau_T_W) noexcept = 0;
  /// Must be called before write(). The argument is true, even if the force is zero, in three cases: the tool touches
  /// tissue, is inside tissue, or its contact is unknown. After a fault or a call of release(), the motors give no
  /// force until the argument has been false for some time. Servo thread only.
  virtual void contact(bool) noexcept {}
  /// Must be called after write(). Receives the servo's result for the last sample. Simulated hands use it to react to
  /// their tool; hardware ignores it. Servo thread; never allocates.
  virtual void see(const ServoTick&) noexcept {}
  /// Returns the fault bits that belong to the sample of the last read().
  virtual std::uint32_t faults() const noexcept { return 0; }
  /// Returns the joint angles of the last read() in rad, starting at the base: the three joints of the arm, then the
  /// three joints of the stylus if it has encoders. Empty if the device does not report angles. Servo thread; valid
  /// until the next read().
  virtual std::span<const double> joints() const noexcept { return {}; }
  /// Returns the state of the safety layer; empty for a device without motors. Servo thread only.
  virtual SafetyStatus safety() noexcept { return {}; }
  /// Sends zero force at once. May be called from any thread and from signal handlers: never allocates, never locks,
  /// and changes only the force.
  virtual void release() noexcept {}
};

}  // namespace typodont::haptics
