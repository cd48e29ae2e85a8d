// Example driver to copy. Its hand moves on a circle (mm) once per second, ignores forces, and presses the pedal
// half of the time.
//
// 1. Derive from HapticDevice. read() waits for the next sample (the servo's clock), write() sends the force, release()
// sends zero force from any thread. None of them throws, allocates or locks.
// 2. Open the device in a function that throws a helpful Error. Access it through Link (link.h), so that tests can
// emulate it.
// 3. Define NAME_driver in drivers/NAME.cpp; `typodont devices` and --hand then know it.
//
// open_hand() adds limits, watchdog, ramps, thermal model, pedal and the base's pose from the rig.
#include <charconv>
#include <cmath>

#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/base/realtime.h"
#include "engine/base/units.h"
#include "haptics/devices.h"

namespace typodont::haptics {

namespace {

class CircleHand : public HapticDevice {
 public:
  CircleHand(std::string address, double radius, double rate, bool paced) : radius_(radius), paced_(paced) {
    info_ = {std::move(address), "circling hand", "", rate};
  }
  const DeviceInfo& info() const noexcept override { return info_; }

  bool read(HandSample& sample) noexcept override {
    const double t = static_cast<double>(index_++) / info_.rate;
    if (index_ == 1) start_ = now();
    if (paced_) sleep_until(start_ + from_seconds(t));
    const double angle = 2 * kPi * t;
    sample = {from_seconds(t),
              {radius_ * dvec3(std::cos(angle), std::sin(angle), 0), {1, 0, 0, 0}},
              std::sin(angle) > 0 ? 1.0 : 0.0};
    return true;
  }
  void write(const dvec3&, const dvec3&) noexcept override {}

 private:
  double radius_;
  bool paced_;
  DeviceInfo info_;
  std::uint64_t index_ = 0;
  Nanos start_ = 0;
};

std::unique_ptr<HapticDevice> open(const std::string& rest, const HandOptions& options) {
  double radius = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), radius);
  if (error != std::errc() || end != rest.data() + rest.size() || !(radius >= 0 && radius <= 1000)) {
    throw Error("circle:" + rest, "", rest.empty() ? "no radius" : rest, "a radius of 0 to 1000 mm");
  }
  return std::make_unique<CircleHand>("circle:" + rest, radius * kMillimetre, options.rate, options.paced);
}

}  // namespace

extern const Driver circle_driver;
const Driver circle_driver{
    .scheme = "circle",
    .rest = "RADIUS_MM",
    .about = "a hand that goes round in a circle: the sample driver",
    .open = open,
    .find = {},
};

}  // namespace typodont::haptics
