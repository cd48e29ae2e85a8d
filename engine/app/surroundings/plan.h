// A scene's description of the surroundings of the working tooth: its neighbours and the gum.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "engine/app/assets.h"
#include "engine/base/json.h"
#include "engine/base/pose.h"
#include "haptics/soft_law.h"

namespace typodont {

/// A neighbour: a copy of the working tooth, mirrored at the contact point. Lengths in metres, frame W.
struct NeighbourTooth {
  dvec3 contact{0, 0, 0};  // contact point; the mirror plane contains it and is perpendicular to the arch
  dvec3 scale{1, 1, 1};    // scale factors about the contact point
  double turn = 0;         // rad, rotation about an axis through the contact point, parallel to the crown's axis
};

struct SurroundingsPlan {
  std::filesystem::path volume;  // volume of the tooth that is copied
  dvec3 crown{0, 0, 1};          // unit, towards the occlusal side
  dvec3 arch{1, 0, 0};           // unit, along the row of teeth, perpendicular to the crown's axis
  std::vector<NeighbourTooth> neighbours;
  bool gum = false;
  dvec3 margin{0, 0, 0};         // a point in the plane of the gum's edge
  dvec3 margin_normal{0, 0, 1};  // normal of the plane of the gum's edge
  double papilla = 2e-3;         // m, additional height of the gum between two teeth
  double thickness = 1.1e-3;     // m, thickness of the gum on the root
  double length = 34e-3;         // m, length of the piece of jaw
  /// Set: the gum yields under an instrument.
  std::optional<haptics::SoftLaw> soft;
};

/// Reads a scene's "surroundings" (docs/interface.md). `volume`: the scene's volume, used unless `json` names another
/// one. Throws Error.
SurroundingsPlan read_surroundings(const Json& json, const std::filesystem::path& volume, const ScenePlace& place);

}  // namespace typodont
