// A hand that may be unplugged and plugged in again within a session.
//
// While it is gone, samples go on at its rate: the last pose, the pedal up, Fault::kDeviceLost. What comes back has
// gone through open_hand() like the first one, so its safety layer gives no force until the hand is free of contact.
// Time counts from the first sample, and goes on across the gap.
#pragma once

#include <functional>
#include <memory>

#include "haptics/devices/reopener.h"
#include "haptics/haptic_device.h"

namespace typodont::haptics {

class ReconnectingDevice : public HapticDevice {
 public:
  struct Options {
    std::function<Nanos()> clock;            // empty: now()
    std::function<void(Nanos)> sleep_until;  // empty: sleep_until()
    std::chrono::milliseconds retry{500};
    Nanos rest = 2 * kNanosPerSecond;  // a device that counts from where it rests must lie still for so long
  };
  /// `open` throws while the device is not there.
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
  /// The servo thread's only: other threads and signal handlers reach the safety layer inside by themselves.
  void release() noexcept override {
    if (device_) device_->release();
  }

 private:
  std::unique_ptr<HapticDevice> open_at_rest() const;

  Options options_;
  std::function<std::unique_ptr<HapticDevice>()> open_;
  std::unique_ptr<HapticDevice> device_;  // none while it is gone
  DeviceInfo info_;
  HandSample last_;
  Nanos began_ = 0, offset_ = 0, due_ = 0;
  bool started_ = false, fresh_ = true;
  std::uint32_t faults_ = 0;
  std::uint32_t lost_events_ = 0;
  Reopener<HapticDevice> reopener_;  // the last member: its thread uses the others
};

}  // namespace typodont::haptics
