// Positions on a tooth: mesial, buccal, floor, occlusal third.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engine/base/json.h"
#include "engine/base/pose.h"
#include "engine/session/cavity.h"
#include "engine/session/strings.h"

namespace typodont::session {

/// In W. The task's axis points to the occlusal side.
struct ToothSides {
  // perpendicular unit vectors
  dvec3 mesial_W{1, 0, 0}, buccal_W{0, 1, 0};
};

/// "tooth" of a scene: {"mesial": [x, y, z], "buccal": [x, y, z]}; empty without. Throws Error.
std::optional<ToothSides> tooth_sides(const Json& scene);

/// Keys of the catalogue after "place.", in every language the same.
struct PlaceName {
  std::string_view part;  // floor, wall (cavity); occlusal, axial, shoulder (crown, filling); margin, cut too far
  std::string_view side;  // from the middle: mesial, …; or "central"
  // Of the height: occlusal, middle, cervical. Empty on floor, shoulder and occlusal surface.
  std::string_view third;
};

/// Relative to all tissue that changed or should have.
PlaceName place_name(const Preparation& preparation, const ToothSides& tooth, const dvec3& p_W);

/// Occlusal, mesial, distal, buccal or lingual; empty in between and from below.
std::string_view side_seen(const ToothSides& tooth, const dvec3& axis_W, const dvec3& look_W);

/// For example "mesiobuccal wall, occlusal third".
std::string place_text(const PlaceName& place, Language language);

}  // namespace typodont::session
