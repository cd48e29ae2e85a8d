// Uses a headset's controller, which produces no force, as input device (the hand). If tracking is lost, the tool stops
// and then yields to the force, so that the force fades. When tracking returns, the tool moves to the hand; the drill
// runs again after the user has released the trigger once. Tracking also counts as lost if a frame takes longer than
// 150 ms (shader compilation after a change of the quality level), because the user would drill without seeing.
#pragma once

#include <memory>

#include "engine/app/wiring.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// Converts the controller's samples to samples of the hand, one by one. Servo thread only.
class XrHandFilter {
 public:
  explicit XrHandFilter(const Pose& start) : pose_(start), from_(start) {}
  /// The hand's next sample. `wanted`: newest sample of the controller. `seen`: true if the controller is tracked now.
  /// `f_T_W`: N, force of the servo in the last tick.
  haptics::HandSample next(const XrHandSample& wanted, bool seen, const dvec3& f_T_W, Nanos t, double dt) noexcept;
  bool lost() const noexcept { return lost_; }

 private:
  Pose pose_, from_;
  double back_ = 0;  // s, time since the tracking of the controller returned
  bool lost_ = true, released_ = false;
};

/// Makes a headset's controller an input device of the servo thread, which reads its samples at `rate` (Hz).
std::unique_ptr<haptics::HapticDevice> make_xr_hand(Wiring& wiring, const std::string& address, const Pose& start,
                                                    double rate);

}  // namespace typodont
