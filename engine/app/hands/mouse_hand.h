// Uses the mouse over the window as a hand. The tool follows the pointer across the picture; the wheel moves the tool
// along the line of sight; the left button is the pedal. With the right button or Shift pressed the mouse tilts the
// tool instead; the middle button sets the tool upright. The mouse gives no force.
#pragma once

#include <memory>
#include <string>

#include "engine/app/wiring.h"
#include "engine/display/display_rig.h"
#include "engine/display/output.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// Parses the text after "mouse:" in an address: mm per notch of the wheel; "" is the default. Returns m. Throws
/// Error.
double wheel_step_of(const std::string& text);

/// Render thread: computes the tool's pose from the window's input.
class Pointer {
 public:
  /// `wheel_step`: m per notch.
  Pointer(const display::DisplayRig& rig, const dvec3& start_W, double wheel_step);
  /// Updates the rig after the picture has changed its shape.
  void follow_rig(const display::DisplayRig& rig) { rig_ = rig; }
  /// Computes the hand from the window's input. `t`: time of this input, on any steady clock.
  haptics::HandSample follow(const display::UserInput& input, Nanos t);
  /// Motion per notch of the wheel, m; the keys Page up and Page down double and halve it.
  double wheel_step() const { return wheel_step_; }

 private:
  /// The screen as the user sees it, and the direction to the eye.
  struct View {
    dvec3 middle{0}, half_right{0}, half_up{0}, toward_eye{0};  // m, W; the last is a unit vector
    dvec3 eye{0};
  };
  View view() const;
  void lean(const glm::dvec2& moved, const View& view);
  dquat rotation() const;

  display::DisplayRig rig_;
  double wheel_step_;
  double depth_ = 0;              // m, distance of the tool in front of the screen's plane, towards the user
  glm::dvec2 lean_;               // rad, tilt of the shank from W's z: to the user's right, and away from the user
  glm::dvec2 at_{0}, offset_{0};  // position of the pointer, −1..1 over the picture, and offset of the tool from it
  bool pressed_ = false;
  Nanos pressed_at_ = -kNanosPerSecond;
};

/// Interpolates the pointer's positions, about sixty per second, to a smooth motion. Servo thread.
class PointerSmoothing {
 public:
  /// `rate`: calls of next() per second.
  PointerSmoothing(const Pose& start, double rate);
  /// The hand at session time `t`, moving towards the latest `wanted`.
  haptics::HandSample next(const haptics::HandSample& wanted, Nanos t) noexcept;

 private:
  Pose pose_;
  double fraction_;  // fraction of the distance to `wanted` that remains after one call
};

/// Makes the hand for the servo thread: it reads the published pointer at `rate` and smooths it.
std::unique_ptr<haptics::HapticDevice> make_mouse_hand(Wiring& wiring, const Pose& start, double rate);

}  // namespace typodont
