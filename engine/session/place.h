// Names positions on a tooth, for example mesial, buccal, floor, occlusal third.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engine/base/json.h"
#include "engine/base/pose.h"
#include "engine/session/cavity.h"
#include "engine/session/strings.h"

namespace typodont::session {

/// Orientation of a tooth in frame W: perpendicular unit vectors.
struct ToothSides {
  dvec3 mesial_W{1, 0, 0}, buccal_W{0, 1, 0};
  std::optional<dvec3> occlusal_W;  // if empty, the task's axis points to the occlusal side
};

/// Declares the keys of "tooth". Throws Error.
void describe_tooth(Keys& keys, ToothSides& sides);
/// Reads "tooth" of a scene; empty if the scene has no such key. Throws Error.
std::optional<ToothSides> tooth_sides(const Json& scene);

/// A place's name: parts that follow "place." in the keys of the text catalogue.
struct PlaceName {
  // Cavity: floor or wall. Crown or filling: occlusal, axial or shoulder. Calculus: buccal, lingual or axial. At the
  // edge: margin.
  std::string_view part;
  std::string_view side;  // direction from the middle: mesial, …; or "central"
  // Third of the height: occlusal, middle, cervical. Empty on floor, shoulder and occlusal surface, and in work from
  // the buccal or lingual side.
  std::string_view third;
};

/// Names the place of p_W, relative to all tissue that changed or should have changed.
PlaceName place_name(const Preparation& preparation, const ToothSides& tooth, const dvec3& p_W);

/// The side that a viewer sees: occlusal, mesial, distal, buccal or lingual. Empty for oblique views and from below.
std::string_view side_seen(const ToothSides& tooth, const dvec3& axis_W, const dvec3& look_W);

/// The place as text, for example "mesiobuccal wall, occlusal third".
std::string place_text(const PlaceName& place, Language language);

}  // namespace typodont::session
