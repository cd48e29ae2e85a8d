// D in W: measured, or with the tissue in front of the user.
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

  /// The runtime will move its space at `time`; X_old_new if known.
  void will_move(XrTime time, const std::optional<Pose>& X_old_new) { moves_.push_back({time, X_old_new}); }
  /// A measured bench stays in the room; otherwise in front of the user again.
  void follow(XrTime display_time);
  /// Unless measured.
  void recentre();
  /// Head in D; places the tissue the first time.
  void see(const Pose& X_DV) {
    if (!known()) place(X_DV);
  }
  bool known() const { return rig_.X_WD || placed_; }
  Pose in_workbench(const Pose& X_DQ) const;

 private:
  /// In front of X_DV. W: y away, z up, user at negative y.
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
