// In the other hand; its thread publishes it for the renderer.
#pragma once

#include "engine/base/pose.h"

namespace typodont {

/// Frame M: origin in the middle of the glass, z out of it. The handle points along (1, 0, 1)/√2, on the reflecting
/// side as on a real one, so that the user can see into the glass. Trivially copyable.
struct MouthMirror {
  Pose X_WM;
  double diameter = 0;  // m, diameter of the glass; 0: no mirror
  double fog = 0;       // 0 (clear) to 1 (fogged)
  double focal = 0;     // m, of a concave mirror; 0: plane
};

// m from a concave glass to the tooth, at which pictures magnify.
inline constexpr double kMirrorWorkDistance = 15e-3;

/// Upright virtual image at kMirrorWorkDistance: 1 / (1 − distance / focal length).
inline double magnification(const MouthMirror& mirror) {
  return mirror.focal > 0 ? 1 / (1 - kMirrorWorkDistance / mirror.focal) : 1;
}

// m, standard size 4, for scenes without a size; size 5 has 24 mm.
inline constexpr double kDefaultMirrorDiameter = 22e-3;

/// X_WM = X_WT * mirror_in_tool(). z of T is along the handle, the origin in the glass's middle.
inline Pose mirror_in_tool() {
  return {{0, 0, 0}, rotation_between(dvec3(std::sqrt(0.5), 0, std::sqrt(0.5)), dvec3(0, 0, 1))};
}

/// The scene's mirror, or the default one, held at X_WT.
inline MouthMirror held(const MouthMirror& scenes, const Pose& X_WT) {
  return {X_WT * mirror_in_tool(), scenes.diameter > 0 ? scenes.diameter : kDefaultMirrorDiameter, scenes.fog,
          scenes.focal};
}

}  // namespace typodont
