// A hand whose device may be unplugged and plugged in again. Meanwhile, the hand reports the last pose, a released
// pedal and Fault::kDeviceLost. The device reopens through open_hand(), so it gives no force until the tool is free
// of contact.
#pragma once

#include <functional>
#include <memory>

#include "haptics/devices/reopener.h"
#include "haptics/haptic_device.h"

namespace typodont::haptics {

class ReconnectingDevice : public HapticDevice {
 public:
  struct Options {
    std::function<Nanos()> clock;            // returns the current time; if empty, now() is used
    std::function<void(Nanos)> sleep_until;  // waits until a time; if empty, typodont::sleep_until() is used
    std::chrono::milliseconds retry{500};
    // Time that a device must rest after opening, if its encoders count from the pose at opening, ns.
    Nanos rest = 2 * kNanosPerSecond;
  };
  /// `open` opens the device again; it throws while the device is missing.
  ReconnectingDevice(std::unique_ptr<HapticDevice> first, std::function<std::unique_ptr<HapticDevice>()> open,
                     Options options);

  const DeviceInfo& info() const noexcept override { return info_; }
  bool read(HandSample& sample) noexcept override;
  void write(const dvec3& f_T_W, const dvec3& tau_T_W) noexcept override;
  void contact(bool touching) noexcept override {
    if (device_) device_->contact(touching);
  }
  std::uint32_t faults() const noexcept override { return device_ ? device_->faults() : faults_; }
  std::span<const double> joints() const noexcept override;
  SafetyStatus safety() noexcept override;
  /// Servo thread only, because device_ may change. Other threads call release_all_devices() (device_safety.h).
  void release() noexcept override {
    if (device_) device_->release();
  }

 private:
  std::unique_ptr<HapticDevice> open_at_rest() const;

  Options options_;
  std::function<std::unique_ptr<HapticDevice>()> open_;
  std::unique_ptr<HapticDevice> device_;  // null while the device is disconnected
  DeviceInfo info_;
  HandSample last_;
  Nanos began_ = 0, offset_ = 0, due_ = 0;
  bool started_ = false, fresh_ = true;
  std::uint32_t faults_ = 0;
  std::uint32_t lost_events_ = 0;
  Reopener<HapticDevice> reopener_;  // declared last, because its thread uses the other members
};

}  // namespace typodont::haptics
