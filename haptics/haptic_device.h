// Interface of a haptic device to the servo loop. Its functions are virtual: the device is chosen at run time.
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
  double force_limit = 0;       // N, largest force; 0: no force output
  double max_stiffness = 0;     // N/m, largest stiffness of the device; 0: unknown
  double torque_limit = 0;      // N·m, largest torque; 0: no torque output
  double continuous_force = 0;  // N, force that the motors can sustain; 0: unknown
  double vibration_band = 0;    // Hz, highest frequency of vibrations; 0: no vibrations
  // Time without new force after which the device outputs zero, s; 0: default.
  double silence = 0;
  double position_step = 0;  // m, motion per encoder count; 0: no encoder, or unknown
  // true: incremental encoders. They count from the pose at opening, which must be the home position.
  bool counts_from_rest = false;
  // true: the samples name the tools, as those of a script or an expert. false: the user chooses the tool.
  bool chooses_tools = false;
};

/// State of a device with motors (devices/safe_device.h).
struct SafetyStatus {
  bool gives_force = false;   // the device has motors
  bool armed = false;         // forces are sent to the motors
  double heat = 0;            // temperature of the windings: 0 cold, 1 at the limit
  double bearable_force = 0;  // N, force that the motors sustain at this temperature
  std::uint32_t events = 0;   // SafetyEvent bits since the last call of safety()
};

/// Haptic device, simulated hand or script. Opened at set-up (throws Error), then used by the servo thread only.
class HapticDevice {
 public:
  virtual ~HapticDevice() = default;
  virtual const DeviceInfo& info() const noexcept = 0;
  /// Waits for the next sample, and so sets the servo's rate. Returns false if the device is lost or the script has
  /// ended.
  virtual bool read(HandSample& sample) noexcept = 0;
  /// Sets force (N) and torque (N·m), frame W, until the next call. The destructor sends zero.
  virtual void write(const dvec3& f_T_W, const dvec3& tau_T_W) noexcept = 0;
  /// Call before write(). The argument is true if the tool touches tissue or is inside tissue, or if this is unknown.
  /// After a fault or release(), the motors stay off until the argument was false for some time. Servo thread only.
  virtual void contact(bool) noexcept {}
  /// Call after write(), with the servo's result for the last sample. Simulated hands react to this result. Servo
  /// thread only; never allocates.
  virtual void see(const ServoTick&) noexcept {}
  /// Returns the Fault bits of the last read().
  virtual std::uint32_t faults() const noexcept { return 0; }
  /// Returns the joint angles in rad, beginning at the base: three of the arm, then three of the stylus if it has
  /// encoders. Empty: not reported. Valid until the next read(). Servo thread only.
  virtual std::span<const double> joints() const noexcept { return {}; }
  /// Returns an empty status for a device without motors. Servo thread only.
  virtual SafetyStatus safety() noexcept { return {}; }
  /// Sets zero force at once. Any thread or signal handler; never allocates or locks.
  virtual void release() noexcept {}
};

}  // namespace typodont::haptics
