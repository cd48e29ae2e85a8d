// The mouse over the window as a hand: it moves the tool parallel to the picture, the wheel moves it in and out, the
// left button is the pedal. It gives no force.
#pragma once

#include <memory>

#include "engine/app/wiring.h"
#include "engine/display/display_rig.h"
#include "engine/display/output.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// Render thread: from what the window saw to where the tool is held.
class Pointer {
 public:
  Pointer(const display::DisplayRig& rig, const dvec3& start_W);
  /// The picture has taken another shape.
  void follow_rig(const display::DisplayRig& rig) { rig_ = rig; }
  haptics::HandSample follow(const display::UserInput& input, Nanos t);

 private:
  display::DisplayRig rig_;
  Pose X_WT_;
  double depth_ = 0;  // m towards the user, from the screen's plane
};

/// Servo thread: reads what the pointer published, at `rate`, smoothed so that 60 positions a second feel like one
/// hand.
std::unique_ptr<haptics::HapticDevice> make_mouse_hand(Wiring& wiring, const Pose& start, double rate);

}  // namespace typodont
