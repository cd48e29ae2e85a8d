// The mouth mirror in the other hand: what the second hand says and the renderer draws.
#pragma once

#include "engine/base/pose.h"

namespace typodont {

/// Frame M: origin in the middle of the glass, z out of the glass. The handle leaves along (1, 0, 1)/√2 of M, on the
/// side that reflects, as in the real one: who holds it sees into it. Trivially copyable.
struct MouthMirror {
  Pose X_WM;
  double diameter = 0;  // m, of the glass; 0: there is no mirror
  double fog = 0;       // 0 clear … 1 breathed on all over
};

inline constexpr double kUsualMirrorDiameter = 22e-3;  // m, size 4, where a scene does not say; size 5 is 24 mm

/// The mirror in the frame of a tool T whose z points along the handle and whose origin is the middle of the glass:
/// X_WM = X_WT * mirror_in_tool().
inline Pose mirror_in_tool() {
  return {{0, 0, 0}, rotation_between(dvec3(std::sqrt(0.5), 0, std::sqrt(0.5)), dvec3(0, 0, 1))};
}

/// The scene's mirror, or a usual one, held as a tool is.
inline MouthMirror held(const MouthMirror& scenes, const Pose& X_WT) {
  return {X_WT * mirror_in_tool(), scenes.diameter > 0 ? scenes.diameter : kUsualMirrorDiameter, scenes.fog};
}

}  // namespace typodont
