// Where on a tooth something is, in a dentist's words: mesial, buccal, floor, occlusal third. Pure functions.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engine/base/json.h"
#include "engine/base/pose.h"
#include "engine/session/cavity.h"
#include "engine/session/strings.h"

namespace typodont::session {

/// How a tooth stands in the workbench. Its occlusal side is where the task's axis points to.
struct ToothSides {
  dvec3 mesial_W{1, 0, 0}, buccal_W{0, 1, 0};  // unit, square to each other
};

/// A scene's "tooth": {"mesial": [x, y, z], "buccal": [x, y, z]}; nothing where it has none. Throws Error.
std::optional<ToothSides> tooth_sides(const Json& scene);

/// Keys of the catalogue ("place." before them), the same in every language.
struct PlaceName {
  std::string_view part;   // floor, wall (of a cavity), occlusal, axial, shoulder (of a crown or filling)
  std::string_view side;   // mesial, mesiobuccal, … as seen from the middle of the work; central near it
  std::string_view third;  // occlusal, middle, cervical: of the work's height along the axis; empty on a floor, a
                           // shoulder and the occlusal surface
};

/// A place on the surface that was left. The work is all that was changed or should have been.
PlaceName place_name(const Preparation& preparation, const ToothSides& tooth, const dvec3& p_W);

/// The side from which one who looks along `look_W` sees the tooth: occlusal, mesial, distal, buccal, lingual; empty
/// from anywhere between them, and from below.
std::string_view side_seen(const ToothSides& tooth, const dvec3& axis_W, const dvec3& look_W);

/// "mesiobuccal wall, occlusal third".
std::string place_text(const PlaceName& place, Language language);

}  // namespace typodont::session
