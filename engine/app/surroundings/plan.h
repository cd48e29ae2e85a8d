// The surroundings of the working tooth as a scene describes them: its neighbours, the gum, the mouth and the rubber
// dam.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "engine/app/assets.h"
#include "engine/app/surroundings/row.h"
#include "engine/base/json.h"
#include "engine/base/pose.h"
#include "haptics/soft_law.h"

namespace typodont {

/// A neighbouring tooth. It is a copy of the working tooth, mirrored at the point of contact. Lengths in m, frame W.
struct NeighbourTooth {
  dvec3 contact{0, 0, 0};  // point of contact; the mirror plane passes through it and is perpendicular to the arch
  dvec3 scale{1, 1, 1};    // scale factors along the axes of frame W, about the point of contact
  double turn = 0;         // rad, rotation about an axis through the point of contact, parallel to the crown's axis
};

/// The mouth that is drawn around the row of teeth. kPhantom: a phantom head (training dummy) with plastic teeth,
/// acrylic gum and a mask.
enum class Mouth { kNone, kPatient, kPhantom };

/// A rubber dam: a sheet with a hole around the working tooth.
struct RubberDam {
  double gap = 0.1e-3;  // m, distance between the edge of the hole and the tooth
  bool clamp = true;    // true: a steel clamp holds the rubber dam's sheet
};

struct SurroundingsPlan {
  std::filesystem::path volume;  // volume of the working tooth, from which neighbours are copied
  dvec3 crown{0, 0, 1};          // unit vector along the crown's axis, towards the chewing surface
  dvec3 arch{1, 0, 0};           // unit vector along the row of teeth, perpendicular to the crown's axis
  std::vector<NeighbourTooth> neighbours;
  std::optional<ToothRow> row;  // the other teeth of the jaw; empty if there are none
  Mouth mouth = Mouth::kNone;
  std::optional<RubberDam> dam;
  bool monitored = true;  // true: damage to the surroundings counts in the score; false: they are only drawn
  bool gum = false;
  dvec3 margin{0, 0, 0};         // m, a point in the plane of the gum's edge
  dvec3 margin_normal{0, 0, 1};  // normal of the plane of the gum's edge
  double papilla = 2e-3;         // m, additional height of the gum between two teeth
  double thickness = 1.1e-3;     // m, thickness of the gum on the root
  double length = 34e-3;         // m, length of the part of the jaw that is drawn
  /// Material of the gum if it yields under an instrument; empty if the gum is rigid.
  std::optional<haptics::SoftLaw> soft;
};

/// Reads the block "surroundings" of a scene (docs/scene_format.md). `volume`: the scene's volume, which is used if the
/// block states no other volume. Throws Error.
SurroundingsPlan read_surroundings(const Json& json, const std::filesystem::path& volume, const ScenePlace& place);

}  // namespace typodont
