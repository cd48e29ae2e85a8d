// Pose of the headset's space D in the workbench W. The pose is either measured, or chosen so that the tissue is in
// front of the user.
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

  /// Stores the announcement of the headset's runtime that it will move its coordinate space at `time`. `X_old_new` is
  /// the pose of the new space in the old space, if known.
  void will_move(XrTime time, const std::optional<Pose>& X_old_new) { moves_.push_back({time, X_old_new}); }
  /// Applies the announced moves of the space. A measured workbench keeps its position in the room. Otherwise the
  /// tissue is placed in front of the user again.
  void follow(XrTime display_time);
  /// Places the tissue in front of the user again, unless its position is measured.
  void recentre();
  /// Reports the pose of the user's head, X_DV, in the headset's space D. If the tissue has no position yet, it is
  /// placed in front of the user.
  void see(const Pose& X_DV) {
    if (!known()) place(X_DV);
  }
  bool known() const { return rig_.X_WD || placed_; }
  Pose in_workbench(const Pose& X_DQ) const;

 private:
  /// Places the tissue in front of the head, which has the pose X_DV in the headset's space D. In frame W, y points
  /// away from the user and z up; the user sits at negative y.
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
