// Safety layer between the servo and a device with motors. Sets zero force at every fault.
//
//   servo ─ write ─▶ finite? armed? ─▶ limits (peak, heat, slew, ramp)   ─▶ device
//                        ▲                                                    ▲
//   servo ─ read ─▶ jump? clock? device fault? ─ trip                         │ zero
//   watchdog thread: no write for 1.8 ms ─ trip ──────────────────────────────┘
//
// A trip sets zero force at once. The force returns slowly after the tool was free of contact for a while; the drill
// also needs a released pedal.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <thread>

#include "haptics/devices/safety.h"
#include "haptics/haptic_device.h"

namespace typodont::haptics {

class SafeDevice : public HapticDevice {
 public:
  struct Options {
    SafetyLimits limits;
    bool watchdog_thread = true;   // false in tests with simulated time, which call watch() themselves
    std::function<Nanos()> clock;  // returns the current time; if empty, now() is used
  };
  /// Options for the device's own limits. The constructor installs the exit guard (device_safety.h).
  static Options options_for(const DeviceInfo& info);

  SafeDevice(std::unique_ptr<HapticDevice> device, Options options);
  ~SafeDevice() override;
  SafeDevice(const SafeDevice&) = delete;
  SafeDevice& operator=(const SafeDevice&) = delete;

  // The following functions are for the servo thread.
  const DeviceInfo& info() const noexcept override { return info_; }
  bool read(HandSample& sample) noexcept override;
  void contact(bool touching) noexcept override { touching_ = touching; }
  void write(const dvec3& f_T_W, const dvec3& tau_T_W) noexcept override;
  std::uint32_t faults() const noexcept override { return faults_; }
  std::span<const double> joints() const noexcept override { return device_->joints(); }
  SafetyStatus safety() noexcept override;
  bool armed() const noexcept { return armed_; }
  double heat() const noexcept { return thermal_.heat; }

  // The following functions are for any thread.
  void release() noexcept override;
  /// Returns all events since the last call, as SafetyEvent bits.
  std::uint32_t take_events() noexcept { return events_.exchange(0); }

  /// Checks at time t whether the servo still writes, and returns the time of the next check. Called by the watchdog
  /// thread or a test.
  Nanos watch(Nanos t) noexcept;

 private:
  void disarm(SafetyEvent event) noexcept;
  void trip(SafetyEvent event) noexcept;  // records the event and sends zero force at once
  /// Disarms the motors if the servo was late: the watchdog has noticed it, or the time t shows it. read() calls this
  /// function too, because the delay would otherwise look like a clock fault.
  void notice_delay(Nanos t) noexcept;
  void note(SafetyEvent event) noexcept { events_.fetch_or(bits(event)); }
  void send(const dvec3& f, const dvec3& tau) noexcept;
  void send_zero() noexcept;
  void gate_pedal(HandSample& sample, double dt) noexcept;

  std::unique_ptr<HapticDevice> device_;
  Options options_;
  DeviceInfo info_;
  bool gives_force_;

  // Only the servo thread uses the following members.
  std::uint32_t faults_ = 0;
  bool started_ = false;
  bool read_once_ = false;
  HandSample last_;
  double dt_ = 0;
  Nanos wrote_ = 0;
  bool armed_ = false;
  bool touching_ = false;
  double gain_ = 0;
  double free_for_ = 0;
  dvec3 last_f_{0}, last_tau_{0};
  ThermalModel thermal_;
  bool pedal_locked_ = true;
  double pedal_held_ = 0;

  // The servo and watchdog threads use the following members.
  std::atomic<std::uint32_t> events_{0};
  std::atomic<bool> force_out_{false};  // true if the device may be applying a force
  std::atomic<bool> tripped_{false};    // the watchdog sent zero force, and the servo has not noticed it yet
  std::atomic<Nanos> last_write_{0};
  std::atomic<bool> ending_{false};
  std::thread watchdog_;
};

}  // namespace typodont::haptics
