#include "engine/display/xr/placement.h"

#include "engine/base/log.h"

namespace typodont::display::xr {

Placement::Placement(const HmdRig& rig, const dvec3& work_W) : rig_(rig), work_W_(work_W) {
  if (rig_.X_WD) X_WD_ = *rig_.X_WD;
}

void Placement::follow(XrTime display_time) {
  while (!moves_.empty() && display_time >= moves_.front().time) {
    const auto& X_old_new = moves_.front().X_old_new;
    if (!rig_.X_WD) {
      placed_ = false;
    } else if (X_old_new) {
      X_WD_ = X_WD_ * *X_old_new;
    } else {
      log::warn("headset: its space moved by an unknown distance: register it with the arm again");
    }
    moves_.pop_front();
  }
}

void Placement::recentre() {
  if (rig_.X_WD)
    log::info("headset: not recentred, the space is measured");
  else
    placed_ = false;
}

void Placement::place(const Pose& X_DV) {
  dvec3 forward = X_DV.R * dvec3(0, 0, -1);
  forward.y = 0;
  // If the user looks straight down or up, the top of the head or the chin points forward and gives the direction.
  if (glm::length(forward) < 0.05) {
    forward = X_DV.R * dvec3(0, (X_DV.R * dvec3(0, 0, -1)).y < 0 ? 1 : -1, 0);
    forward.y = 0;
  }
  forward = glm::normalize(forward);
  const dvec3 up(0, 1, 0), right = glm::cross(forward, up);
  const dquat R_DW(glm::dmat3(right, forward, up));
  const dvec3 p_DWork = X_DV.p + rig_.distance * forward - rig_.below * up;
  X_WD_.R = glm::normalize(glm::conjugate(R_DW));
  X_WD_.p = work_W_ - X_WD_.R * (p_DWork / rig_.magnify);
  placed_ = true;
}

Pose Placement::in_workbench(const Pose& X_DQ) const {
  return {X_WD_.p + X_WD_.R * (X_DQ.p / rig_.magnify), X_WD_.R * X_DQ.R};
}

}  // namespace typodont::display::xr
