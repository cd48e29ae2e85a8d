// What a picture shows, and its viewpoint. Plain data.
#pragma once

#include <cstdint>

#include "engine/contract/tissue.h"
#include "engine/display/display_rig.h"
#include "engine/render/renderer.h"

namespace typodont {

/// What a picture shows of the scene. The trainee's picture and the observer's picture can have different looks.
struct Look {
  render::View view = render::View::kLook;
  /// Axis of frame W that is perpendicular to the section plane (render::cuts_section): 0 x, 1 y, 2 z.
  int section_axis = 1;
  double section = 0;  // m, position of the section plane along section_axis, from the middle of caries or tooth
  /// Section plane (xyz: unit normal, w: offset in m). If it is zero, section_axis and section are used.
  glm::dvec4 plane{0};
  std::uint32_t hidden = 0;  // hidden tissues, one bit for each; used only in View::kLook
  bool tool = true, debris = true, mirror = true, surroundings = true;

  bool operator==(const Look&) const = default;
  bool hides(Tissue tissue) const { return (hidden >> static_cast<unsigned>(tissue) & 1u) != 0; }
};

/// A free viewpoint around the tooth, without eye tracking.
struct Viewpoint {
  double azimuth = -1.5707963267948966;  // rad, angle from the x axis of frame W to the viewer's direction, about z
  double elevation = 1.0;                // rad, angle of the viewer's direction above the horizontal plane
  double distance = 0.15;                // m, distance from the tooth's middle to the viewer
  glm::dvec2 shift{0, 0};                // m, displacement of the viewed point, right and up

  bool operator==(const Viewpoint&) const = default;
};

/// Limits a viewpoint to valid values: the viewer stays outside the tooth, and the view does not pass the zenith.
Viewpoint clamped(const Viewpoint& from);

/// Makes a display rig whose picture has this size (pixels) and this viewpoint. It shows the region around `middle_W`.
display::DisplayRig rig_of(const Viewpoint& from, const dvec3& middle_W, glm::ivec2 pixels);

/// Converts the eye position of a display rig's user to a valid viewpoint (clamped()) around the point `middle_W`.
Viewpoint viewpoint_of(const display::DisplayRig& rig, const dvec3& middle_W);

/// A vertical section plane through the point `through_W`. It faces the viewer at p_WE; the tissue behind it is kept.
glm::dvec4 section_facing(const dvec3& through_W, const dvec3& p_WE);

/// Returns the section plane that `look` states (xyz: unit normal, w: offset in m). The viewer is at p_WE; the tissue
/// behind the plane is kept.
glm::dvec4 section_plane(const Look& look, const dvec3& middle_W, const dvec3& p_WE);

}  // namespace typodont
