// The mouse as a hand without force. Pointer: across the picture; wheel: along the tool; left button: pedal;
// right button or Shift: tilt; middle button: upright.
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

/// After "mouse:": mm per notch, empty: default. Returns m. Throws Error.
double wheel_step_of(const std::string& text);

/// The tool's pose from the window's input. Render thread only.
class Pointer {
 public:
  /// `wheel_step`: m per notch.
  Pointer(const display::DisplayRig& rig, const dvec3& start_W, double wheel_step);
  /// Above tissue that hides it: along the shank from the visible surface. Before the session, because the volume
  /// belongs to the carver.
  void come_into_sight(const haptics::TissueVolume& tissue);
  /// When the picture's size or shape has changed.
  void follow_rig(const display::DisplayRig& rig) { rig_ = rig; }
  /// `t`: of the input, any steady clock. `touching_W`: the tool's head, if tissue holds it back; the hand is at most
  /// kMaxLead ahead of it.
  haptics::HandSample follow(const display::UserInput& input, Nanos t,
                             const std::optional<dvec3>& touching_W = std::nullopt);
  static constexpr double kMaxLead = 1e-3;  // m
  /// m per notch. Page up doubles it, Page down halves it.
  double wheel_step() const { return wheel_step_; }

 private:
  /// The screen as the user sees it, and the way to the eye.
  struct View {
    // m, W: middle; to the middle of the right and upper edge; unit vector
    dvec3 middle{0}, half_right{0}, half_up{0}, toward_eye{0};
    dvec3 eye{0};
  };
  View view() const;
  void lean(const glm::dvec2& moved, const View& view);
  dquat rotation() const;

  display::DisplayRig rig_;
  double wheel_step_;
  double depth_ = 0;  // m in front of the screen's plane, of the plane in which the pointer moves the tool
  dvec3 slid_W_{0};   // m, by the wheel
  /// rad, of the shank from z: to the user's right, away from him
  glm::dvec2 lean_;
  /// pointer, and tool from pointer, in half pictures
  glm::dvec2 at_{0}, offset_{0};
  bool pressed_ = false;
  Nanos pressed_at_ = -kNanosPerSecond;
};

/// Smooths the pointer's sixty positions per second. Servo thread only.
class PointerSmoothing {
 public:
  /// `rate`: calls of next() per second.
  PointerSmoothing(const Pose& start, double rate);
  /// Approaches `wanted`, the pointer's latest position. `t`: session time.
  haptics::HandSample next(const haptics::HandSample& wanted, Nanos t) noexcept;

 private:
  Pose pose_;
  double fraction_;  // of the distance left after one call
};

/// For the servo thread; reads the pointer at `rate` (Hz).
std::unique_ptr<haptics::HapticDevice> make_mouse_hand(Wiring& wiring, const Pose& start, double rate);

}  // namespace typodont
