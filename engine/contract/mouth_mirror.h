// The mouth mirror in the user's other hand. The thread of that hand publishes it, and the renderer draws it.
#pragma once

#include "engine/base/pose.h"

namespace typodont {

/// Frame M: origin in the middle of the glass, z out of the glass. The handle points along (1, 0, 1)/√2 of M, on the
/// reflecting side as on a real mirror, so that the user can look into the mirror. Trivially copyable.
struct MouthMirror {
  Pose X_WM;
  double diameter = 0;  // m, diameter of the glass; 0: no mirror
  double fog = 0;       // 0: clear … 1: completely fogged
  double focal = 0;     // m, focal length of a concave, magnifying mirror; 0: a plane front-surface mirror
};

// m, distance from the glass for which a concave mirror's magnification is drawn: a tooth that is looked at in it
inline constexpr double kMirrorWorkDistance = 15e-3;

/// Magnification of an upright virtual image of an object at kMirrorWorkDistance: 1 / (1 − distance / focal length).
inline double magnification(const MouthMirror& mirror) {
  return mirror.focal > 0 ? 1 / (1 - kMirrorWorkDistance / mirror.focal) : 1;
}

// m, diameter of size 4, the default if the scene states none; size 5 has 24 mm
inline constexpr double kDefaultMirrorDiameter = 22e-3;

/// Pose of the mirror in the frame of a tool T whose z points along the handle and whose origin is the middle of the
/// glass: X_WM = X_WT * mirror_in_tool().
inline Pose mirror_in_tool() {
  return {{0, 0, 0}, rotation_between(dvec3(std::sqrt(0.5), 0, std::sqrt(0.5)), dvec3(0, 0, 1))};
}

/// The scene's mirror, or the default mirror if it has none, at the pose of tool T.
inline MouthMirror held(const MouthMirror& scenes, const Pose& X_WT) {
  return {X_WT * mirror_in_tool(), scenes.diameter > 0 ? scenes.diameter : kDefaultMirrorDiameter, scenes.fog,
          scenes.focal};
}

}  // namespace typodont
