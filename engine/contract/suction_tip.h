// A suction tip, a tube with a slanted opening, in the user's other hand. The hand's thread publishes it for the
// renderer.
#pragma once

#include "engine/base/pose.h"

namespace typodont {

/// Frame S: origin in the middle of the opening, z along the tube, away from the opening. S is also the hand's tool
/// frame. Trivially copyable.
struct SuctionTip {
  Pose X_WS;
  double opening = 0;     // m, inner diameter of the opening; 0: no tip
  double wall = 0.5e-3;   // m, thickness of the tube's wall
  double slant = 0;       // rad, angle between the opening and the tube's cross-section
  double length = 70e-3;  // m, length of the tube
};

}  // namespace typodont
