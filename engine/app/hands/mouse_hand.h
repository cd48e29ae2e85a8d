// The mouse as a hand without force. The pointer moves the tool across the picture, the wheel along the tool's axis;
// left button: pedal; right button or Shift: tilts the tool; middle button: undoes the tilt.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "engine/app/wiring.h"
#include "engine/display/display_rig.h"
#include "engine/display/output.h"
#include "haptics/haptic_device.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Parses the text after "mouse:", mm per notch of the wheel; empty: the default. Returns m per notch. Throws Error.
double wheel_step_of(const std::string& text);

/// Computes the tool's pose from window input. Render thread only.
class Pointer {
 public:
  /// `wheel_step`: m per notch of the wheel. `axis_W`: unit vector along which the shank starts; empty: tilted away
  /// from the user, so that the bur is visible.
  Pointer(const display::DisplayRig& rig, const dvec3& start_W, double wheel_step,
          const std::optional<dvec3>& axis_W = std::nullopt);
  /// If tissue hides the tool, moves it to the surface that the user sees and from there out along the shank. Call
  /// before the session starts, because then only the carver thread may use the volume.
  void come_into_sight(const haptics::TissueVolume& tissue);
  /// Call with the new rig when the size or shape of the picture has changed.
  void follow_rig(const display::DisplayRig& rig) { rig_ = rig; }
  /// Computes the next sample. `t`: time of the input, on any steady clock. `touching_W`: position of the tool's head,
  /// if tissue holds it back; the hand is then at most kMaxLead ahead of it.
  haptics::HandSample follow(const display::UserInput& input, Nanos t,
                             const std::optional<dvec3>& touching_W = std::nullopt);
  static constexpr double kMaxLead = 1e-3;  // m, limit for the hand's distance ahead of a head that tissue holds back
  /// m of tool motion per notch of the wheel. Page up doubles it, Page down halves it.
  double wheel_step() const { return wheel_step_; }

 private:
  /// The screen as the user sees it, and the direction to the eye.
  struct View {
    // Frame W, m: middle of the screen; from there to the middle of the right and of the upper edge; unit vector to the
    // eye.
    dvec3 middle{0}, half_right{0}, half_up{0}, toward_eye{0};
    dvec3 eye{0};
  };
  View view() const;
  void lean(const glm::dvec2& moved, const View& view);
  dquat rotation() const;

  display::DisplayRig rig_;
  double wheel_step_;
  // m, distance from the screen's plane to the plane in front of it in which the pointer moves the tool
  double depth_ = 0;
  dvec3 slid_W_{0};   // m, displacement of the tool by the wheel
  dquat along_axis_;  // rotation from z to the axis
  /// Tilt of the shank from the axis, rad: to the user's right, and away from the user.
  glm::dvec2 lean_;
  /// Position of the pointer, and displacement from the pointer to the tool, in halves of the picture.
  glm::dvec2 at_{0}, offset_{0};
  bool pressed_ = false;
  Nanos pressed_at_ = -kNanosPerSecond;
};

/// Smooths the pointer's positions, of which there are sixty per second. Servo thread only.
class PointerSmoothing {
 public:
  /// `rate`: number of calls of next() per second.
  PointerSmoothing(const Pose& start, double rate);
  /// Moves towards `wanted`, the pointer's latest position. `t`: session time.
  haptics::HandSample next(const haptics::HandSample& wanted, Nanos t) noexcept;

 private:
  Pose pose_;
  double fraction_;  // fraction of the remaining distance covered per call
};

/// Makes the hand for the servo thread, which reads the pointer at `rate` (Hz).
std::unique_ptr<haptics::HapticDevice> make_mouse_hand(Wiring& wiring, const Pose& start, double rate);

}  // namespace typodont
