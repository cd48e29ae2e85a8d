// The mouse over the window as a hand: it moves the tool across the picture, always under the pointer, the wheel moves
// it in and out along the line of sight, the left button is the pedal. With the right button or Shift held the tool
// leans instead of moving; the middle button sets it upright. It gives no force.
#pragma once

#include <memory>
#include <string>

#include "engine/app/wiring.h"
#include "engine/display/display_rig.h"
#include "engine/display/output.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// m a notch of the wheel, from what follows "mouse:" in an address: "" the usual step, else mm. Throws Error.
double wheel_step_of(const std::string& text);

/// Render thread: from what the window saw to where the tool is held.
class Pointer {
 public:
  /// `wheel_step`: m a notch.
  Pointer(const display::DisplayRig& rig, const dvec3& start_W, double wheel_step);
  /// The picture has taken another shape.
  void follow_rig(const display::DisplayRig& rig) { rig_ = rig; }
  /// `t`: of this look at the window, on any steady clock.
  haptics::HandSample follow(const display::UserInput& input, Nanos t);
  /// m a notch; the keys Page up and Page down double and halve it.
  double wheel_step() const { return wheel_step_; }

 private:
  /// The screen as the user sees it, and from where.
  struct View {
    dvec3 middle{0}, half_right{0}, half_up{0}, toward_eye{0};  // m, W; the last is a unit vector
    dvec3 eye{0};
  };
  View view() const;
  void lean(const glm::dvec2& moved, const View& view);
  dquat rotation() const;

  display::DisplayRig rig_;
  double wheel_step_;
  double depth_ = 0;              // m from the screen's plane to the tool, along its normal, towards the user
  glm::dvec2 lean_;               // rad, of the shank from W's z: to the user's right, and away from the user
  glm::dvec2 at_{0}, offset_{0};  // of the pointer, −1..1 over the picture, and of the tool from it
  bool pressed_ = false;
  Nanos pressed_at_ = -kNanosPerSecond;
};

/// Sixty positions a second as one smooth hand. Servo thread.
class PointerSmoothing {
 public:
  /// `rate`: calls of next() a second.
  PointerSmoothing(const Pose& start, double rate);
  /// The hand at `t`, the session's time, on its way to the newest `wanted`.
  haptics::HandSample next(const haptics::HandSample& wanted, Nanos t) noexcept;

 private:
  Pose pose_;
  double share_;  // of the way that is left, a call
};

/// Servo thread: reads what the pointer published, at `rate`, smoothed.
std::unique_ptr<haptics::HapticDevice> make_mouse_hand(Wiring& wiring, const Pose& start, double rate);

}  // namespace typodont
