// A scene's description of the surroundings of the working tooth: its neighbours and the gum.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/app/assets.h"
#include "engine/base/json.h"
#include "engine/base/pose.h"

namespace typodont {

/// A neighbour: a copy of the working tooth, mirrored at the contact point. Metres, W.
struct NeighbourTooth {
  dvec3 contact{0, 0, 0};  // contact point; the mirror plane goes through it, perpendicular to the arch
  dvec3 scale{1, 1, 1};    // scale factors about the contact point
  double turn = 0;         // rad about the crown's axis through the contact point
};

struct SurroundingsPlan {
  std::filesystem::path volume;  // volume of the tooth that is copied
  dvec3 crown{0, 0, 1};          // unit, towards the occlusal side
  dvec3 arch{1, 0, 0};           // unit, along the row of teeth, perpendicular to the crown's axis
  std::vector<NeighbourTooth> neighbours;
  bool gum = false;
  dvec3 margin{0, 0, 0};         // point of the plane of the gum's edge on the tooth
  dvec3 margin_normal{0, 0, 1};  // normal of that plane
  double papilla = 2e-3;         // m, additional height of the gum between two teeth
  double thickness = 1.1e-3;     // m, thickness of the gum on the root
  double length = 34e-3;         // m, length of the piece of jaw
};

/// Reads a scene's "surroundings" (docs/interface.md); `volume` is the scene's own. Throws Error.
SurroundingsPlan read_surroundings(const Json& json, const std::filesystem::path& volume, const ScenePlace& place);

}  // namespace typodont
