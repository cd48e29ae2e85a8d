// In the other hand, a tube with a slanted opening; its thread publishes it for the renderer.
#pragma once

#include "engine/base/pose.h"

namespace typodont {

/// Frame S: origin in the middle of the opening, z along the tube away from it; also the hand's tool frame. Trivially
/// copyable.
struct SuctionTip {
  Pose X_WS;
  double opening = 0;     // m, inner; 0: no tip
  double wall = 0.5e-3;   // m, thickness of the tube's wall
  double slant = 0;       // rad, from the tube's cross-section
  double length = 70e-3;  // m, length of the tube
};

}  // namespace typodont
