// Where the headset's space D lies in the workbench W: measured, or so that the work is before the user.
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

  /// The runtime will move its space at that time, so far, where it knows.
  void will_move(XrTime time, const std::optional<Pose>& X_old_new) { moves_.push_back({time, X_old_new}); }
  /// The space moved: what was measured stays where it is in the room; what was put before the user is put there again.
  void follow(XrTime display_time);
  /// Puts the work before the user again, where it was not measured.
  void recentre();
  /// The head was located at X_DV: puts the work before it where it has no place yet.
  void see(const Pose& X_DV) {
    if (!known()) place(X_DV);
  }
  bool known() const { return rig_.X_WD || placed_; }
  Pose in_workbench(const Pose& X_DQ) const;

 private:
  /// W's y away from the user, its z up (the user sits where W's negative y is).
  void place(const Pose& X_DV);

  struct Move {
    XrTime time;
    std::optional<Pose> X_old_new;  // the new space in the old one
  };
  HmdRig rig_;
  dvec3 work_W_;
  Pose X_WD_;
  bool placed_ = false;
  std::deque<Move> moves_;
};

}  // namespace typodont::display::xr
