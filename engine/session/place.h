// Names positions on a tooth in dental terms: mesial, buccal, floor, occlusal third. Pure functions.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engine/base/json.h"
#include "engine/base/pose.h"
#include "engine/session/cavity.h"
#include "engine/session/strings.h"

namespace typodont::session {

/// Orientation of a tooth in the workbench. The task's axis points to its occlusal side.
struct ToothSides {
  dvec3 mesial_W{1, 0, 0}, buccal_W{0, 1, 0};  // unit, perpendicular to each other
};

/// Reads a scene's "tooth": {"mesial": [x, y, z], "buccal": [x, y, z]}; returns no value if the scene has no "tooth".
/// Throws Error.
std::optional<ToothSides> tooth_sides(const Json& scene);

/// A name as keys of the text catalogue (after the prefix "place."); the keys are the same in every language.
struct PlaceName {
  std::string_view part;  // floor, wall (of a cavity), occlusal, axial, shoulder (of a crown or filling)
  std::string_view side;  // mesial, mesiobuccal, …: direction from the work's centre; central: near it
  // third of the work's height along the axis: occlusal, middle or cervical; empty on a floor, a shoulder or the
  // occlusal surface
  std::string_view third;
};

/// Names a point on the final surface. The work is all tissue that was changed or should have been changed.
PlaceName place_name(const Preparation& preparation, const ToothSides& tooth, const dvec3& p_W);

/// The side that faces a viewer who looks along `look_W`: occlusal, mesial, distal, buccal, lingual. Empty for
/// directions in between, and for a view from below.
std::string_view side_seen(const ToothSides& tooth, const dvec3& axis_W, const dvec3& look_W);

/// The name as text, for example "mesiobuccal wall, occlusal third".
std::string place_text(const PlaceName& place, Language language);

}  // namespace typodont::session
