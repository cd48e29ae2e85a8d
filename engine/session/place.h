// Names positions on a tooth in dental terms: mesial, buccal, floor, occlusal third.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engine/base/json.h"
#include "engine/base/pose.h"
#include "engine/session/cavity.h"
#include "engine/session/strings.h"

namespace typodont::session {

/// Orientation of a tooth in frame W. The task's axis points to the occlusal side of the tooth.
struct ToothSides {
  // unit vectors towards the mesial and the buccal side, perpendicular to each other
  dvec3 mesial_W{1, 0, 0}, buccal_W{0, 1, 0};
};

/// Reads the value "tooth" of a scene: {"mesial": [x, y, z], "buccal": [x, y, z]}. Returns no value if the scene has no
/// "tooth". Throws Error.
std::optional<ToothSides> tooth_sides(const Json& scene);

/// The name of a position. Its parts are keys of the text catalogue (after the prefix "place."), so they are the same
/// in every language.
struct PlaceName {
  std::string_view part;  // floor or wall (of a cavity); occlusal, axial or shoulder (of a crown or filling)
  std::string_view side;  // direction from the middle of the changed tissue: mesial, …; "central" near the middle
  // The changed tissue is divided by height into three thirds: occlusal, middle and cervical. This is the third in
  // which the position lies. Empty on a floor, a shoulder or the occlusal surface.
  std::string_view third;
};

/// Returns the name of a point on the final surface. The name states the position relative to the changed tissue: all
/// tissue that was changed or should have been changed.
PlaceName place_name(const Preparation& preparation, const ToothSides& tooth, const dvec3& p_W);

/// Returns the side of the tooth that is seen in the viewing direction `look_W`: occlusal, mesial, distal, buccal or
/// lingual. Empty for directions in between, and for a view from below.
std::string_view side_seen(const ToothSides& tooth, const dvec3& axis_W, const dvec3& look_W);

/// Returns the name as text, for example "mesiobuccal wall, occlusal third".
std::string place_text(const PlaceName& place, Language language);

}  // namespace typodont::session
