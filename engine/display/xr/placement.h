// Pose of the headset's space D on the workbench: measured, or chosen so that the tissue is in front of the user.
#pragma once

#include <openxr/openxr.h>

#include <deque>
#include <optional>

#include "engine/base/pose.h"
#include "engine/display/display_rig.h"

namespace typodont::display::xr {

class Placement {
 public:
  Placement(const HmdRig& rig, const dvec3& work_W);

  /// Notes a change of the headset's frame D at `time`. `X_old_new`: pose of the new frame in the old one, if known.
  void will_move(XrTime time, const std::optional<Pose>& X_old_new) { moves_.push_back({time, X_old_new}); }
  /// Applies the noted changes of the headset's frame D. If the workbench's pose was measured, the workbench keeps its
  /// place in the room; otherwise the tissue is placed in front of the user again.
  void follow(XrTime display_time);
  /// Places the tissue in front of the user again, unless its pose was measured.
  void recentre();
  /// Passes the user's head pose in the headset's space D. The first call places the tissue in front of the user.
  void see(const Pose& X_DV) {
    if (!known()) place(X_DV);
  }
  bool known() const { return rig_.X_WD || placed_; }
  Pose in_workbench(const Pose& X_DQ) const;

 private:
  /// Places the tissue in front of the head X_DV. W: y away from the user, z up; the user is at negative y.
  void place(const Pose& X_DV);

  struct Move {
    XrTime time;
    std::optional<Pose> X_old_new;  // pose of the new space in the old space
  };
  HmdRig rig_;
  dvec3 work_W_;
  Pose X_WD_;
  bool placed_ = false;
  std::deque<Move> moves_;
};

}  // namespace typodont::display::xr
