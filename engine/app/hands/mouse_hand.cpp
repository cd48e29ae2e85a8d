#include "engine/app/hands/mouse_hand.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "engine/base/error.h"
#include "engine/base/ticker.h"
#include "engine/base/units.h"
#include "engine/display/keys.h"

namespace typodont {

namespace {

constexpr double kUsualStep = 0.15e-3;                  // m of tool motion per notch of the wheel, default
constexpr double kMinStep = 0.005e-3, kMaxStep = 2e-3;  // m of tool motion per notch, limits
// Time constant with which the tool follows the pointer, s.
constexpr double kFollowTime = 15e-3;
constexpr double kMaxDepth = 30e-3;  // m, limit of the distance from the screen's plane, and of the wheel's motion
// m; a tool that tissue hides is moved this far out of the surface along its shank, so that its tilted head is free.
constexpr double kStartClear = 2e-3;
// Shortest press of the pedal, ns, so that a short click has an effect.
constexpr Nanos kShortestPress = 50'000'000;
// Tilt of the tool at the start of a scene without task, rad.
constexpr glm::dvec2 kRestingLean{0, 24 * kDegree};
constexpr double kMaxLean = 85 * kDegree;  // rad, largest tilt that the mouse can set
// Tilt of the tool per pointer motion of half the height of the picture, rad.
constexpr double kLeanPerHalfHeight = 60 * kDegree;
// When the user tilts the tool, the pointer moves away from the tool's head. Each later pointer motion reduces this
// offset by this fraction of the motion's length.
constexpr double kReturn = 0.5;

class MouseHand : public haptics::HapticDevice {
 public:
  MouseHand(Wiring& wiring, const Pose& start, double rate) : wiring_(wiring), ticker_(rate), smoothing_(start, rate) {
    info_ = {"mouse:", "mouse over the window", "", rate, 0, 0};
    wanted_.X_WT = start;
  }
  const haptics::DeviceInfo& info() const noexcept override { return info_; }

  bool read(haptics::HandSample& sample) noexcept override {
    const Nanos t = ticker_.next();
    if (wiring_.pointer.fetch()) wanted_ = wiring_.pointer.front();
    sample = smoothing_.next(wanted_, t);
    return true;  // the servo ends the session, not this hand
  }
  void write(const dvec3&, const dvec3&) noexcept override {}

 private:
  Wiring& wiring_;
  Ticker ticker_;
  haptics::DeviceInfo info_;
  haptics::HandSample wanted_;
  PointerSmoothing smoothing_;
};

}  // namespace

double wheel_step_of(const std::string& text) {
  if (text.empty()) return kUsualStep;
  char* end = nullptr;
  const double step = std::strtod(text.c_str(), &end) * kMillimetre;
  if (end != text.c_str() + text.size() || !(step >= kMinStep && step <= kMaxStep))
    throw Error("--hand", "", "mouse:" + text,
                fmt::format("mouse: or mouse:STEP_MM, {:g} to {:g} mm a notch of the wheel", kMinStep / kMillimetre,
                            kMaxStep / kMillimetre));
  return step;
}

Pointer::Pointer(const display::DisplayRig& rig, const dvec3& start_W, double wheel_step,
                 const std::optional<dvec3>& axis_W)
    : rig_(rig),
      wheel_step_(wheel_step),
      along_axis_(rotation_between({0, 0, 1}, axis_W.value_or(dvec3(0, 0, 1)))),
      lean_(axis_W ? glm::dvec2(0) : kRestingLean) {
  const View seen = view();
  depth_ = glm::dot(start_W - seen.middle, seen.toward_eye);
}

void Pointer::come_into_sight(const haptics::TissueVolume& tissue) {
  const View seen = view();
  const double distance = glm::dot(seen.eye - seen.middle, seen.toward_eye);
  const VoxelFrame& frame = tissue.frame();
  glm::ivec3 lo, hi;
  tissue.bounds(lo, hi);
  const auto free = [&](const dvec3& p) {
    const glm::ivec3 at(glm::round(frame.to_voxels(p)));
    if (glm::any(glm::lessThan(at, lo)) || glm::any(glm::greaterThan(at, hi))) return true;
    float outside = 0;  // voxels, distance from the surface, positive outside
    tissue.copy(at, glm::ivec3(1), &outside, nullptr);
    return outside > 0;
  };
  for (double depth = std::min(kMaxDepth, 0.9 * distance); depth > depth_; depth -= frame.voxel) {
    const dvec3 p = seen.middle + depth / distance * (seen.eye - seen.middle);
    if (free(p)) continue;
    depth_ = depth;
    const dvec3 shank = rotation() * dvec3(0, 0, 1);
    double clear = 0, motion = frame.voxel;
    for (; motion < kMaxDepth && clear < kStartClear; motion += frame.voxel)
      clear = free(p + motion * shank) ? clear + frame.voxel : 0;
    slid_W_ = motion * shank;
    return;
  }
}

Pointer::View Pointer::view() const {
  const display::Screen screen = rig_.mirror ? display::reflect(*rig_.mirror, rig_.screen) : rig_.screen;
  View v;
  v.half_right = 0.5 * (screen.lower_right - screen.lower_left);
  v.half_up = 0.5 * (screen.upper_left - screen.lower_left);
  v.middle = screen.lower_left + v.half_right + v.half_up;
  v.eye = rig_.head.eye_center;
  const dvec3 normal = glm::normalize(glm::cross(v.half_right, v.half_up));
  v.toward_eye = glm::dot(normal, v.eye - v.middle) > 0 ? normal : -normal;
  return v;
}

/// Tilts the tool. `moved`: pointer motion, as a fraction of half the picture's width and height.
void Pointer::lean(const glm::dvec2& moved, const View& view) {
  const dvec3 motion = moved.x * view.half_right + moved.y * view.half_up;
  const double half_height = glm::length(view.half_up);
  // Axes as the user sees them: mirrors and rotated panels turn the picture.
  const dvec3 right = rig_.head.right, up = glm::normalize(glm::cross(view.toward_eye, right));
  const glm::dvec2 turned =
      lean_ + kLeanPerHalfHeight / half_height * glm::dvec2(glm::dot(motion, right), glm::dot(motion, up));
  lean_ = glm::clamp(turned, glm::dvec2(-kMaxLean), glm::dvec2(kMaxLean));
}

dquat Pointer::rotation() const {
  const dvec3 z(0, 0, 1), level = rig_.head.right - z * rig_.head.right.z;
  const dvec3 x = glm::length(level) > 1e-3 ? glm::normalize(level) : dvec3(1, 0, 0), away = glm::cross(z, x);
  const dquat upright(glm::dmat3(x, away, z));
  return glm::angleAxis(lean_.x, along_axis_ * away) * glm::angleAxis(-lean_.y, along_axis_ * x) * along_axis_ *
         upright;
}

haptics::HandSample Pointer::follow(const display::UserInput& input, Nanos t, const std::optional<dvec3>& touching_W) {
  for (const int key : input.pressed) {
    if (key == display::keys::kPageUp) wheel_step_ = std::min(2 * wheel_step_, kMaxStep);
    if (key == display::keys::kPageDown) wheel_step_ = std::max(wheel_step_ / 2, kMinStep);
  }
  const View seen = view();
  const glm::dvec2 moved = input.pointer - at_;
  at_ = input.pointer;
  if (input.right || input.shift) {
    lean(moved, seen);
    offset_ -= moved;  // the pointer tilts the tool without moving the head
  } else {
    // The offset changes only while the pointer moves, so that a tool at rest does not move.
    const double left = glm::length(offset_);
    if (left > 0) offset_ *= std::max(0.0, 1 - kReturn * glm::length(moved) / left);
  }
  if (input.middle) lean_ = glm::dvec2(0);
  const dquat R_WT = rotation();
  const dvec3 slid = slid_W_ + input.wheel * wheel_step_ * (R_WT * dvec3(0, 0, 1));
  if (glm::length(slid) <= kMaxDepth) slid_W_ = slid;

  const glm::dvec2 over = at_ + offset_;
  const dvec3 on_screen = seen.middle + over.x * seen.half_right + over.y * seen.half_up;
  const double distance = glm::dot(seen.eye - on_screen, seen.toward_eye);
  const double depth = std::min(depth_, 0.9 * distance);
  dvec3 p = on_screen + depth / distance * (seen.eye - on_screen) + slid_W_;
  if (touching_W) {
    const dvec3 lead = p - *touching_W, past = lead * (1 - kMaxLead / std::max(glm::length(lead), kMaxLead));
    // Discards the wheel's motion beyond kMaxLead. The pointer's motion is kept, because the user sees the pointer.
    const dvec3 axis = R_WT * dvec3(0, 0, 1);
    slid_W_ -= glm::dot(past, axis) * axis;
    p -= past;
  }

  if (input.left && !pressed_) pressed_at_ = t;
  pressed_ = input.left;
  const bool down = pressed_ || t - pressed_at_ < kShortestPress;
  return {t, {p, R_WT}, down ? 1.0 : 0.0};
}

PointerSmoothing::PointerSmoothing(const Pose& start, double rate)
    : pose_(start), fraction_(1 - std::exp(-1 / (rate * kFollowTime))) {}

haptics::HandSample PointerSmoothing::next(const haptics::HandSample& wanted, Nanos t) noexcept {
  pose_ = {glm::mix(pose_.p, wanted.X_WT.p, fraction_), glm::slerp(pose_.R, wanted.X_WT.R, fraction_)};
  return {t, pose_, wanted.pedal};
}

std::unique_ptr<haptics::HapticDevice> make_mouse_hand(Wiring& wiring, const Pose& start, double rate) {
  return std::make_unique<MouseHand>(wiring, start, rate);
}

}  // namespace typodont
