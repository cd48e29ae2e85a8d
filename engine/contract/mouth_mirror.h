// The mouth mirror in the user's other hand. The thread of that hand publishes it, and the renderer draws it.
#pragma once

#include "engine/base/pose.h"

namespace typodont {

/// A mouth mirror. The origin of its frame M is the middle of the glass, and z points out of the glass. The handle
/// points in the direction (1, 0, 1)/√2 in M. It is on the reflecting side, as on a real mirror, so that the user can
/// see into the mirror. Trivially copyable.
struct MouthMirror {
  Pose X_WM;
  double diameter = 0;  // m, diameter of the glass; 0: no mirror
  double fog = 0;       // fog on the glass, 0 (clear) to 1 (completely fogged)
  double focal = 0;     // m, focal length of a concave, magnifying mirror; 0 if the mirror is plane
};

// m, distance from the glass of a concave mirror to the tooth that the user looks at. Pictures show the mirror with the
// magnification that it has at this distance.
inline constexpr double kMirrorWorkDistance = 15e-3;

/// Returns the magnification of the upright virtual image of an object at the distance kMirrorWorkDistance: 1 / (1 −
/// distance / focal length).
inline double magnification(const MouthMirror& mirror) {
  return mirror.focal > 0 ? 1 / (1 - kMirrorWorkDistance / mirror.focal) : 1;
}

// m, default diameter of a mouth mirror, for scenes that state none. It is the diameter of the standard size 4; size 5
// has 24 mm.
inline constexpr double kDefaultMirrorDiameter = 22e-3;

/// Returns the pose of the mirror in the frame T of the tool that holds it: X_WM = X_WT * mirror_in_tool(). The z axis
/// of T points along the handle, and its origin is the middle of the glass.
inline Pose mirror_in_tool() {
  return {{0, 0, 0}, rotation_between(dvec3(std::sqrt(0.5), 0, std::sqrt(0.5)), dvec3(0, 0, 1))};
}

/// Returns the mirror that a hand holds: the scene's mirror, or the default mirror if the scene has none. The mirror's
/// pose is computed from the pose X_WT of the tool frame T.
inline MouthMirror held(const MouthMirror& scenes, const Pose& X_WT) {
  return {X_WT * mirror_in_tool(), scenes.diameter > 0 ? scenes.diameter : kDefaultMirrorDiameter, scenes.fog,
          scenes.focal};
}

}  // namespace typodont
