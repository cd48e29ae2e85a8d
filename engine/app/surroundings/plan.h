// What a scene says of what stands around the working tooth: its neighbours and the gum.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/app/assets.h"
#include "engine/base/json.h"
#include "engine/base/pose.h"

namespace typodont {

/// A tooth like the working one, mirrored where the two touch. Metres, W.
struct NeighbourTooth {
  dvec3 contact{0, 0, 0};  // the point where they touch: mirrored in the plane through it, square to the arch
  dvec3 scale{1, 1, 1};    // about the contact
  double turn = 0;         // rad about the crown's axis through the contact
};

struct SurroundingsPlan {
  std::filesystem::path volume;  // whose tooth is copied
  dvec3 crown{0, 0, 1};          // unit, towards the biting side
  dvec3 arch{1, 0, 0};           // unit, along the row of teeth, square to the crown's axis
  std::vector<NeighbourTooth> neighbours;
  bool gum = false;
  dvec3 margin{0, 0, 0};         // the gum's edge on the tooth: a plane through this point …
  dvec3 margin_normal{0, 0, 1};  // … square to this
  double papilla = 2e-3;         // m, how much higher the gum stands between two teeth
  double thickness = 1.1e-3;     // m, of the gum on the root
  double length = 34e-3;         // m, of the piece of jaw
};

/// Reads a scene's "surroundings" (docs/interface.md); `volume` is the scene's own. Throws Error.
SurroundingsPlan read_surroundings(const Json& json, const std::filesystem::path& volume, const ScenePlace& place);

}  // namespace typodont
