// A hand that may be disconnected and connected again during a session. While it is disconnected, samples continue at
// its rate. They contain the last pose, a released pedal and Fault::kDeviceLost. A reconnected device is opened by
// open_hand() like the first one, so its safety layer gives no force until the hand is free of contact. The time of the
// samples counts from the first sample and continues while the device is disconnected.
#pragma once

#include <functional>
#include <memory>

#include "haptics/devices/reopener.h"
#include "haptics/haptic_device.h"

namespace typodont::haptics {

class ReconnectingDevice : public HapticDevice {
 public:
  struct Options {
    std::function<Nanos()> clock;            // returns the present time; if empty, now() is used
    std::function<void(Nanos)> sleep_until;  // waits until a time; if empty, sleep_until() is used
    std::chrono::milliseconds retry{500};
    // Time in ns for which a device must rest when it is opened, if its encoders count from the rest position.
    Nanos rest = 2 * kNanosPerSecond;
  };
  /// `open` opens the device again. It throws while the device is missing.
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
  /// Only the servo thread calls this function. Other threads and signal handlers call the inner safety layer directly.
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
