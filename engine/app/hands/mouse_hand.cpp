#include "engine/app/hands/mouse_hand.h"

#include <algorithm>
#include <cmath>

#include "engine/base/realtime.h"

namespace typodont {

namespace {

constexpr double kWheelStep = 0.15e-3;  // m a notch
constexpr double kFollowTime = 15e-3;   // s, of the smoothing
constexpr double kMostDepth = 30e-3;    // m

class MouseHand : public haptics::HapticDevice {
 public:
  MouseHand(Wiring& wiring, const Pose& start, double rate) : wiring_(wiring), rate_(rate) {
    info_ = {"mouse:", "mouse over the window", "", rate, 0, 0};
    pose_ = wanted_.X_WT = start;
    start_ = now();
  }
  const haptics::DeviceInfo& info() const noexcept override { return info_; }

  bool read(haptics::HandSample& sample) noexcept override {
    const Nanos t = from_seconds(static_cast<double>(index_++) / rate_);
    sleep_until(start_ + t);
    if (wiring_.pointer.fetch()) wanted_ = wiring_.pointer.front();
    const double share = 1 - std::exp(-1 / (rate_ * kFollowTime));
    pose_ = {glm::mix(pose_.p, wanted_.X_WT.p, share), wanted_.X_WT.R};
    sample = {t, pose_, wanted_.pedal};
    return true;  // the servo decides when to end
  }
  void write(const dvec3&, const dvec3&) noexcept override {}

 private:
  Wiring& wiring_;
  double rate_;
  haptics::DeviceInfo info_;
  haptics::HandSample wanted_;
  Pose pose_;
  Nanos start_ = 0;
  std::uint64_t index_ = 0;
};

}  // namespace

Pointer::Pointer(const display::DisplayRig& rig, const dvec3& start_W) : rig_(rig) {
  const display::Screen& screen = rig.screen;
  const dvec3 normal =
      glm::normalize(glm::cross(screen.lower_right - screen.lower_left, screen.upper_left - screen.lower_left));
  const dvec3 up = glm::normalize(screen.upper_left - screen.lower_left);
  depth_ = glm::dot(start_W - screen.lower_left, normal);
  // Held like a pen from above and behind: the shank leans away from the user.
  X_WT_ = {start_W, rotation_between({0, 0, 1}, glm::normalize(up - 0.3 * normal))};
}

haptics::HandSample Pointer::follow(const display::UserInput& input, Nanos t) {
  const display::Screen& screen = rig_.screen;
  const dvec3 right = screen.lower_right - screen.lower_left, up = screen.upper_left - screen.lower_left;
  const dvec3 normal = glm::normalize(glm::cross(right, up));
  depth_ = std::clamp(depth_ + input.wheel * kWheelStep, -kMostDepth, kMostDepth);
  X_WT_.p = screen.lower_left + (input.pointer.x + 1) / 2 * right + (input.pointer.y + 1) / 2 * up + depth_ * normal;
  return {t, X_WT_, input.left ? 1.0 : 0.0};
}

std::unique_ptr<haptics::HapticDevice> make_mouse_hand(Wiring& wiring, const Pose& start, double rate) {
  return std::make_unique<MouseHand>(wiring, start, rate);
}

}  // namespace typodont
