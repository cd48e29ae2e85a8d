// Uses the mouse over the window as a hand. The tool follows the pointer across the picture. The wheel moves the tool
// along the line of sight. The left button is the pedal. While the right button or Shift is pressed, the mouse tilts
// the tool instead of moving it. The middle button sets the tool upright. The mouse gives no force.
#pragma once

#include <memory>
#include <string>

#include "engine/app/wiring.h"
#include "engine/display/display_rig.h"
#include "engine/display/output.h"
#include "haptics/haptic_device.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Parses the text after "mouse:" in an address. The text is the tool's motion in mm per notch of the wheel; an empty
/// text means the default. Returns m. Throws Error.
double wheel_step_of(const std::string& text);

/// Computes the tool's pose from the window's input. Render thread only.
class Pointer {
 public:
  /// `wheel_step`: motion of the tool per notch of the wheel, m.
  Pointer(const display::DisplayRig& rig, const dvec3& start_W, double wheel_step);
  /// If the tissue hides the tool in the middle of the picture, moves the tool in front of the tissue. Called before
  /// the session, because the volume belongs to the carver.
  void come_into_sight(const haptics::TissueVolume& tissue);
  /// Replaces the display rig after the size or shape of the picture has changed.
  void follow_rig(const display::DisplayRig& rig) { rig_ = rig; }
  /// Computes the hand's next sample from the window's input. `t`: time of this input, on any steady clock.
  haptics::HandSample follow(const display::UserInput& input, Nanos t);
  /// Returns the motion (m) of the tool per notch of the wheel. The key Page up doubles it, Page down halves it.
  double wheel_step() const { return wheel_step_; }

 private:
  /// Position and axes of the screen, as the user sees them, and the direction to the eye.
  struct View {
    // m, frame W. middle: middle of the screen; half_right, half_up: vectors from there to the middle of the right and
    // of the upper edge; toward_eye: unit vector
    dvec3 middle{0}, half_right{0}, half_up{0}, toward_eye{0};
    dvec3 eye{0};
  };
  View view() const;
  void lean(const glm::dvec2& moved, const View& view);
  dquat rotation() const;

  display::DisplayRig rig_;
  double wheel_step_;
  double depth_ = 0;  // m, distance of the tool in front of the screen's plane, towards the user
  /// rad, tilt of the shank from the z axis of frame W: to the user's right, and away from the user
  glm::dvec2 lean_;
  /// position of the pointer, and offset of the tool from the pointer, in units of half the picture
  glm::dvec2 at_{0}, offset_{0};
  bool pressed_ = false;
  Nanos pressed_at_ = -kNanosPerSecond;
};

/// Interpolates between the pointer's positions (about sixty per second), which gives a smooth motion of the hand.
/// Servo thread only.
class PointerSmoothing {
 public:
  /// `rate`: number of calls of next() per second.
  PointerSmoothing(const Pose& start, double rate);
  /// Returns the hand's sample at the session time `t`. Its position approaches the latest position of the pointer,
  /// `wanted`.
  haptics::HandSample next(const haptics::HandSample& wanted, Nanos t) noexcept;

 private:
  Pose pose_;
  double fraction_;  // fraction of the distance to the wanted position that remains after one call of next()
};

/// Makes the hand for the servo thread. It reads the pointer's latest position at `rate` (Hz) and smooths it.
std::unique_ptr<haptics::HapticDevice> make_mouse_hand(Wiring& wiring, const Pose& start, double rate);

}  // namespace typodont
