// Between a hand's device and the servo. Virtual: sessions use different devices.
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
  double force_limit = 0;       // N; 0: no force output
  double max_stiffness = 0;     // N/m, largest stiffness of the device; 0: unknown
  double torque_limit = 0;      // N·m; 0: no torque output
  double continuous_force = 0;  // N, sustained by the motors; 0: unknown
  double vibration_band = 0;    // Hz, of vibrations; 0: none
  // s without a force until it is zero; 0: default
  double silence = 0;
  double position_step = 0;  // m, an encoder count; 0: none, or unknown
  // relative to the pose at opening, which must be the home position
  bool counts_from_rest = false;
};

/// Of a device with motors (devices/safe_device.h).
struct SafetyStatus {
  bool gives_force = false;   // the device has motors
  bool armed = false;         // forces pass to the hand
  double heat = 0;            // of the windings, 0..1 of the limit
  double bearable_force = 0;  // N, sustained at the present heat
  std::uint32_t events = 0;   // SafetyEvent bits since the last safety()
};

/// Haptic device, simulated hand or script. Opened at set-up (throws Error), then the servo thread's.
class HapticDevice {
 public:
  virtual ~HapticDevice() = default;
  virtual const DeviceInfo& info() const noexcept = 0;
  /// Waits for the next sample, which times the servo. False: lost, or script at its end.
  virtual bool read(HandSample& sample) noexcept = 0;
  /// N and N·m, W, until the next call. The destructor sends zero.
  virtual void write(const dvec3& f_T_W, const dvec3& tau_T_W) noexcept = 0;
  /// Before write(). True if the tool touches or is in tissue, or if that is unknown, even at zero force. After a fault
  /// or release(), motors stay off until it was false for some time. Servo thread.
  virtual void contact(bool) noexcept {}
  /// After write(): the result of the last sample. Simulated hands react to it. Servo thread; never allocates.
  virtual void see(const ServoTick&) noexcept {}
  /// Of the last read().
  virtual std::uint32_t faults() const noexcept { return 0; }
  /// rad, from the base: three of the arm, three of the stylus if encoded. Empty: not reported. Servo thread; until the
  /// next read().
  virtual std::span<const double> joints() const noexcept { return {}; }
  /// Empty without motors. Servo thread.
  virtual SafetyStatus safety() noexcept { return {}; }
  /// Zero force at once. Any thread or signal handler: no allocation, no lock.
  virtual void release() noexcept {}
};

}  // namespace typodont::haptics
