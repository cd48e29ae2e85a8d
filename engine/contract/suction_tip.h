// A suction tip in the user's other hand: a tube with a slanted opening. The thread of that hand publishes it, and the
// renderer draws it.
#pragma once

#include "engine/base/pose.h"

namespace typodont {

/// Frame S: origin in the middle of the opening; z along the tube, away from the opening. A hand that holds the tip has
/// its tool frame there. Trivially copyable.
struct SuctionTip {
  Pose X_WS;
  double opening = 0;     // m, inner diameter; 0: no tip
  double wall = 0.5e-3;   // m
  double slant = 0;       // rad, angle between the opening and the tube's cross-section
  double length = 70e-3;  // m
};

}  // namespace typodont
