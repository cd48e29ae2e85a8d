// The surroundings of the working tooth as a scene describes them: neighbours, gum, mouth, rubber dam.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "engine/app/assets.h"
#include "engine/app/tissue/row.h"
#include "engine/base/json.h"
#include "engine/base/pose.h"
#include "haptics/soft_tissue.h"

namespace typodont {

/// A neighbour: mirror image of the working tooth. m, frame W.
struct NeighbourTooth {
  dvec3 contact{0, 0, 0};  // point where both teeth touch, in the mirror plane
  dvec3 normal{1, 0, 0};   // unit normal of the mirror plane
  dvec3 scale{1, 1, 1};    // scaling about `contact`: factors along the arch, across it, along the crown's axis
};

/// The mouth around the jaw. kPhantom: plastic teeth, acrylic gum and a mask.
enum class Mouth { kNone, kPatient, kPhantom };

struct RubberDam {
  double gap = 0.1e-3;  // m, distance of the hole's edge from the tooth
  bool clamp = true;    // true: a steel clamp holds the rubber dam's sheet
};

struct SurroundingsPlan {
  std::filesystem::path volume;  // volume of the working tooth, from which neighbours are copied
  dvec3 crown{0, 0, 1};          // unit vector along the crown's axis, towards the chewing surface
  dvec3 arch{1, 0, 0};           // unit vector along the arch, perpendicular to the crown's axis
  std::vector<NeighbourTooth> neighbours;
  std::optional<ToothRow> row;  // the other teeth of the jaw; empty: none
  Mouth mouth = Mouth::kNone;
  std::optional<RubberDam> dam;
  bool monitored = true;  // true: damage is measured; false: only drawn
  bool gum = false;
  dvec3 margin{0, 0, 0};         // m, a point in the plane of the gum's edge
  dvec3 margin_normal{0, 0, 1};  // normal of the plane of the gum's edge
  double papilla = 2e-3;         // m, additional height of the gum between two teeth
  double thickness = 1.1e-3;     // m, thickness of the gum on the root
  double length = 34e-3;         // m, length of the drawn part of the jaw
  /// Parameters of the soft gum; empty: the gum is rigid.
  std::optional<haptics::SoftLaw> soft;
};

/// Declares the keys of the block "surroundings". `volume`: the scene's volume, used if the block names none. Throws
/// Error.
void describe_surroundings(Keys& keys, SurroundingsPlan& plan, const std::filesystem::path& volume,
                           const ScenePlace& place);

}  // namespace typodont
