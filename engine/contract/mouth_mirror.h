// A mouth mirror in the user's other hand. The hand's thread publishes it for the renderer.
#pragma once

#include "engine/base/pose.h"

namespace typodont {

/// Frame M: origin in the middle of the glass, z out of the glass. The handle points along (1, 0, 1)/√2, on the
/// reflecting side as on a real mirror, so that the user can see into the glass. Trivially copyable.
struct MouthMirror {
  Pose X_WM;
  double diameter = 0;  // m, diameter of the glass; 0: no mirror
  double fog = 0;       // 0 (clear) to 1 (fogged)
  double focal = 0;     // m, focal length of a concave mirror; 0: plane
};

// Distance from a concave glass to the tooth for which magnifications are stated, m.
inline constexpr double kMirrorWorkDistance = 15e-3;

/// Magnification of the upright virtual image at kMirrorWorkDistance: 1 / (1 − distance / focal length).
inline double magnification(const MouthMirror& mirror) {
  return mirror.focal > 0 ? 1 / (1 - kMirrorWorkDistance / mirror.focal) : 1;
}

// Diameter if the scene states none, m: standard size 4. Size 5 has 24 mm.
inline constexpr double kDefaultMirrorDiameter = 22e-3;

/// Pose of the mirror in the tool frame: X_WM = X_WT * mirror_in_tool(). T has its origin in the middle of the glass,
/// and z along the handle.
inline Pose mirror_in_tool() {
  return {{0, 0, 0}, rotation_between(dvec3(std::sqrt(0.5), 0, std::sqrt(0.5)), dvec3(0, 0, 1))};
}

/// The scene's mirror, or the default one, held by a hand at pose X_WT.
inline MouthMirror held(const MouthMirror& scenes, const Pose& X_WT) {
  return {X_WT * mirror_in_tool(), scenes.diameter > 0 ? scenes.diameter : kDefaultMirrorDiameter, scenes.fog,
          scenes.focal};
}

}  // namespace typodont
