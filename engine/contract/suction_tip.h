// A suction tip in the user's other hand: a tube with a slanted opening. The thread of that hand publishes it, and the
// renderer draws it.
#pragma once

#include "engine/base/pose.h"

namespace typodont {

/// A suction tip. The origin of its frame S is the middle of the opening, and z points along the tube, away from the
/// opening. S is also the tool frame of the hand that holds the tip. Trivially copyable.
struct SuctionTip {
  Pose X_WS;
  double opening = 0;     // m, inner diameter of the tube; 0 if there is no tip
  double wall = 0.5e-3;   // m, thickness of the tube's wall
  double slant = 0;       // rad, angle between the opening and the tube's cross-section
  double length = 70e-3;  // m, length of the tube
};

}  // namespace typodont
