#include "engine/app/live/xr_hand.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/ticker.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

// Time constant of the smoothing, s. With it, 90 controller positions per second feel like a continuous motion.
constexpr double kSmoothingTime = 10e-3;
constexpr double kReturnTime = 0.4;  // s, duration of the tool's motion back to the hand
// Admittance, m/(s·N): while tracking is lost, the tool moves away from the tissue with this speed per newton of force.
// At a stiffness of 1 N/mm, the force fades within 50 ms.
constexpr double kLostHandAdmittance = 0.02;
// Largest speed at which the tool yields to the force while tracking is lost, m/s.
constexpr double kMaxLostHandSpeed = 0.05;
// The trigger counts as released if its position (0 to 1) is smaller than this.
constexpr double kReleased = 0.1;
// Tracking counts as lost if the newest sample is older than this, ns.
constexpr Nanos kStale = 150'000'000;

class XrHand : public haptics::HapticDevice {
 public:
  XrHand(Wiring& wiring, const std::string& address, const Pose& start, double rate)
      : wiring_(wiring), ticker_(rate), filter_(start) {
    info_ = {address, "headset controller", "", rate, 0, 0};
  }
  const haptics::DeviceInfo& info() const noexcept override { return info_; }

  bool read(haptics::HandSample& sample) noexcept override {
    const Nanos t = ticker_.next();
    if (wiring_.xr_hand.fetch()) wanted_ = wiring_.xr_hand.front();
    const bool seen = wanted_.tracked && now() - wanted_.t < kStale;
    sample = filter_.next(wanted_, seen, force_, t, 1 / info_.rate);
    return true;  // never false, so this device never ends the session
  }
  void write(const dvec3& f_T_W, const dvec3&) noexcept override { force_ = f_T_W; }
  std::uint32_t faults() const noexcept override { return filter_.lost() ? bits(Fault::kDeviceLost) : 0; }

 private:
  Wiring& wiring_;
  Ticker ticker_;
  haptics::DeviceInfo info_;
  XrHandSample wanted_;
  XrHandFilter filter_;
  dvec3 force_{0};
};

}  // namespace

haptics::HandSample XrHandFilter::next(const XrHandSample& wanted, bool seen, const dvec3& f_T_W, Nanos t,
                                       double dt) noexcept {
  if (!seen) {
    lost_ = true;
    const double force = glm::length(f_T_W);
    if (force > 0) pose_.p += f_T_W * (std::min(kLostHandAdmittance * force, kMaxLostHandSpeed) / force * dt);
    return {t, pose_, 0};
  }
  if (lost_) {
    lost_ = released_ = false;
    from_ = pose_;
    back_ = 0;
  }
  back_ += dt;
  released_ = released_ || wanted.pedal < kReleased;
  if (back_ < kReturnTime) {
    const double s = back_ / kReturnTime, smooth = s * s * (3 - 2 * s);
    pose_ = interpolate(from_, wanted.X_WT, smooth);
    return {t, pose_, 0};
  }
  pose_ = interpolate(pose_, wanted.X_WT, 1 - std::exp(-dt / kSmoothingTime));
  return {t, pose_, released_ ? wanted.pedal : 0};
}

std::unique_ptr<haptics::HapticDevice> make_xr_hand(Wiring& wiring, const std::string& address, const Pose& start,
                                                    double rate) {
  return std::make_unique<XrHand>(wiring, address, start, rate);
}

}  // namespace typodont
