#include "haptics/devices/reconnecting.h"

#include <algorithm>

#include "engine/base/error.h"
#include "engine/base/realtime.h"
#include "engine/contract/contact.h"
#include "haptics/devices/safety.h"

namespace typodont::haptics {

namespace {

// Largest motion of a resting arm, m; an arm that a hand holds moves more.
constexpr double kStill = 1e-4;

}  // namespace

ReconnectingDevice::ReconnectingDevice(std::unique_ptr<HapticDevice> first,
                                       std::function<std::unique_ptr<HapticDevice>()> open, Options options)
    : options_(std::move(options)),
      open_(std::move(open)),
      device_(std::move(first)),
      info_(device_->info()),
      reopener_([this] { return open_at_rest(); }, options_.retry) {
  if (!options_.clock) options_.clock = [] { return now(); };
  if (!options_.sleep_until) options_.sleep_until = [](Nanos t) { typodont::sleep_until(t); };
}

/// Opens the device again, on the reopener's thread. Throws while the device is missing.
std::unique_ptr<HapticDevice> ReconnectingDevice::open_at_rest() const {
  std::unique_ptr<HapticDevice> device = open_();
  if (!info_.serial.empty() && device->info().serial != info_.serial) {
    // this is another device, because its serial number is different
    throw Error(info_.address, "", device->info().serial, info_.serial);
  }
  if (!info_.counts_from_rest) return device;
  // The encoders count from the pose at opening, so the arm must rest in its home position; an arm that a hand holds
  // moves more than kStill.
  HandSample first, sample;
  if (!device->read(first)) return nullptr;
  const double samples = to_seconds(options_.rest) * info_.rate;
  for (int i = 0; i < samples; ++i) {
    device->write(dvec3(0), dvec3(0));
    if (!device->read(sample) || glm::length(sample.X_WT.p - first.X_WT.p) > kStill) return nullptr;
  }
  return device;
}

bool ReconnectingDevice::read(HandSample& sample) noexcept {
  if (!device_) {
    if ((device_ = reopener_.take())) fresh_ = true;
  }
  if (device_) {
    HandSample raw;
    if (device_->read(raw)) {
      if (fresh_) {  // the clock of the new device may have restarted
        fresh_ = false;
        const Nanos t = options_.clock();
        if (!started_) began_ = t;
        offset_ = (started_ ? std::max(t - began_, last_.t + 1) : 0) - raw.t;
        started_ = true;
      }
      raw.t += offset_;
      sample = last_ = raw;
      return true;
    }
    if (!started_) return false;
    lost_events_ |= device_->safety().events | bits(SafetyEvent::kDeviceLost);
    due_ = options_.clock();
    reopener_.want(std::move(device_));
  }
  // While the device is missing, time advances and the hand keeps its pose.
  due_ += from_seconds(1 / info_.rate);
  options_.sleep_until(due_);
  faults_ = bits(Fault::kDeviceLost);
  last_.t = std::max(last_.t + 1, due_ - began_);
  last_.pedal = 0;
  sample = last_;
  return true;
}

void ReconnectingDevice::write(const dvec3& f_T_W, const dvec3& tau_T_W) noexcept {
  if (device_) device_->write(f_T_W, tau_T_W);
}

std::span<const double> ReconnectingDevice::joints() const noexcept {
  return device_ ? device_->joints() : std::span<const double>{};
}

SafetyStatus ReconnectingDevice::safety() noexcept {
  SafetyStatus status;
  if (device_) status = device_->safety();
  status.gives_force = info_.force_limit > 0;
  status.events |= lost_events_;
  lost_events_ = 0;
  return status;
}

}  // namespace typodont::haptics
