// A headset's controller as the hand. It gives no force; losing it freezes the tool, and what pressed it into the
// tissue gives way, so that the force fades; coming back it is led to where it is, and drills only after the trigger
// was let go once.
#pragma once

#include <memory>

#include "engine/app/wiring.h"
#include "haptics/haptic_device.h"

namespace typodont {

/// What one sample does to the hand: state in, state out. Servo thread.
class XrHandFilter {
 public:
  explicit XrHandFilter(const Pose& start) : pose_(start), from_(start) {}
  /// `seen`: the controller's newest sample is of now. `f_T_W`: the servo's force of the last tick, N.
  haptics::HandSample next(const XrHandSample& wanted, bool seen, const dvec3& f_T_W, Nanos t, double dt) noexcept;
  bool lost() const noexcept { return lost_; }

 private:
  Pose pose_, from_;
  double back_ = 0;  // s since it came back
  bool lost_ = true, released_ = false;
};

/// Servo thread: reads what the headset's thread published, at `rate`.
std::unique_ptr<haptics::HapticDevice> make_xr_hand(Wiring& wiring, const std::string& address, const Pose& start,
                                                    double rate);

}  // namespace typodont
